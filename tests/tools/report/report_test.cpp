// odom evaluate of whole drives, and its report.
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/drive_tables.hpp"

namespace odomd::tools::report_test {
namespace {

// One short lap for all tests; it ends where it began. Tests use the full filter, which is slow
// under sanitizers, only where they need it.
class Report : public ::testing::Test {
 protected:
  static const Scratch& scratch() {
    static const SharedDrive made{"--scenario circle --laps 1 --speed 1.5 --standstill 2 --seed 3",
                                  "lap"};
    return made.scratch;
  }
  static Outcome run(const std::string& arguments) {
    return scratch().run("odom evaluate " + arguments);
  }
  /// The lap in the JSON of an evaluation.
  static nlohmann::json drive_json(const std::string& arguments) {
    return scratch().json("odom evaluate --json --drive lap " + arguments)["drives"][0];
  }
  /// The page of an evaluation of the lap that must succeed.
  static std::string page(const std::string& how) {
    scratch().must_run("odom evaluate --drive lap --html page.html" + how);
    return scratch().text("page.html");
  }
  /// Writes turned.toml, in which the gyro has the wrong sign.
  static void turn_gyro() {
    const std::regex gyro("(yaw_rate = .*unit = \"rad/s\")");
    scratch().write("turned.toml",
                    std::regex_replace(scratch().text("lap/car.toml"), gyro, "$1, scale = -1"));
  }
};

TEST_F(Report, OfADriveIsThePapersTable) {
  const Outcome outcome = run("--drive lap --dead-reckoning");
  EXPECT_THAT(outcome, Ends(0, ""));
  EXPECT_THAT(
      outcome.out,
      AllOf(HasSubstr("end [cm/m]"), HasSubstr("heading end [deg]"), HasSubstr("35 ms [mm]"),
            HasSubstr("end better by [%]"), HasSubstr("\nkinematic "), HasSubstr("\npaper "),
            HasSubstr("\ninertial "), HasSubstr("\nfull "), HasSubstr("samples of full\n"),
            ContainsRegex("source +fused +gated +late +other +tested +NIS / expected")));
}

TEST_F(Report, ComparesWithTheModelInertialOnlyWhereThereIsAGyro) {
  scratch().must_run("grep -v ^yaw_rate lap/car.toml > no_gyro.toml");
  const Outcome usual = run("--drive lap --config no_gyro.toml");
  EXPECT_EQ(usual.status, 0) << usual.err;
  EXPECT_THAT(usual.out, AllOf(HasSubstr("\npaper "), Not(HasSubstr("inertial"))));
  EXPECT_THAT(run("--drive lap --config no_gyro.toml --model inertial"),
              Ends(2, HasSubstr("no_gyro.toml: [can.signals]: yaw_rate is not mapped")));
}

TEST_F(Report, OfADriveHasTheFiguresOfItsPoseFiles) {
  nlohmann::json json, full;
  for (const auto& [without, with] :
       {std::pair{"", " --camera lap/camera.csv"}, {" --dead-reckoning", ""}}) {
    json = scratch().json(
        std::string(
            "odom evaluate --json --drive lap --align none --model kinematic --model full") +
        without);
    const auto file =
        errors_of_replay(scratch(), std::string("--config lap/car.toml --can lap/drive.log") + with,
                         "lap/truth.csv --align none");
    full = json["drives"][0]["estimates"][1];
    EXPECT_EQ(full["pose"], "full");
    for (const char* figure : {"end_error", "path_length", "samples", "heading", "error_35ms"})
      EXPECT_EQ(full[figure], file[figure]) << figure << with;
  }
  EXPECT_EQ(full["improvement_percent"]["against"], "kinematic");
  EXPECT_EQ(full["horizons"].size(), 10U);
  EXPECT_EQ(full["horizons"][3]["horizon"], 0.035);
  EXPECT_EQ(full["horizons"][3]["position"], full["error_35ms"]["position"]);
  EXPECT_GT(full["innovations"]["yaw_rate"]["count"], 500);
  EXPECT_GT(full["verdicts"]["steering"]["fused"], 500);
  EXPECT_EQ(json["drives"][0]["verdict"]["subject"], "full by dead reckoning");
  EXPECT_EQ(json["summary"][1]["estimate"], "full");
}

TEST_F(Report, ComparesWithTheBaselineThatIsNamed) {
  const auto against = [](const std::string& name) {
    return drive_json("--model paper --model kinematic --baseline " +
                      name)["estimates"][0]["improvement_percent"];
  };
  EXPECT_TRUE(against("paper").is_null());
  EXPECT_EQ(against("kinematic")["against"], "kinematic");
}

TEST_F(Report, TakesACameraInWithoutAligning) {
  const auto align = [](const std::string& how) {
    return drive_json("--model paper" + how)["align"];
  };
  EXPECT_EQ(align(""), "none");
  EXPECT_EQ(align(" --dead-reckoning"), "first");
  EXPECT_EQ(align(" --frame odom"), "first");  // this frame uses no camera pose
  EXPECT_EQ(align(" --align fit"), "fit");
}

TEST_F(Report, OfSeveralDrivesHasTheMeansAndDrawsTheErrorsBySpeed) {
  EXPECT_THAT(
      scratch().must_run("odom evaluate --drive lap --drive lap --model kinematic --model paper"),
      AllOf(ContainsRegex("mean of 2 +kinematic"), ContainsRegex("mean of 2 +paper"),
            Not(HasSubstr("samples of"))));
  simulate(scratch(), "--speed 0.8 --duration 8", "slow");
  scratch().must_run(
      "odom evaluate --drive lap --drive slow --model paper --model full --dead-reckoning "
      "--picture speed.svg");
  const std::string svg = scratch().text("speed.svg");
  for (const char* axis : {"mean speed [m/s]", "35 ms error mean [mm]", "end error [cm/m]",
                           "heading error at the end [deg]", "paper", "full"})
    EXPECT_THAT(svg, HasSubstr(axis));
}

TEST_F(Report, DistinguishesDrivesOfOneName) {
  scratch().must_run("mkdir other && cp -r lap other");
  EXPECT_THAT(run("--drive lap --drive other/lap --model kinematic --dead-reckoning").out,
              AllOf(HasSubstr("\nlap "), HasSubstr("\nother/lap ")));
  EXPECT_EQ(scratch().json(
                "odom evaluate --json --drive other/lap --model kinematic")["drives"][0]["drive"],
            "lap");
}

TEST_F(Report, OfAClosedLoopNeedsNoReference) {
  const auto json = drive_json("--dead-reckoning --closed-loop --model paper");
  EXPECT_EQ(json["closed_loop"], true);
  const auto& paper = json["estimates"][0];
  EXPECT_LT(paper["end_error_cm_per_m"], 3.0);
  EXPECT_FALSE(paper.contains("position"));
  EXPECT_FALSE(paper.contains("nees"));
  // With camera poses, the end error is the camera's; this note is printed once for all drives.
  constexpr auto note =
      "--closed-loop with camera poses: the error at the end is only as good as the camera";
  const std::string closed = "--drive lap --closed-loop --model paper";
  const std::string said = run(closed + " --drive lap").err;
  EXPECT_THAT(said, HasSubstr(note));
  EXPECT_EQ(said.find(note), said.rfind(note));
  EXPECT_THAT(run(closed + " --dead-reckoning").err, Not(HasSubstr(note)));
  EXPECT_THAT(run(closed + " --frame odom").err, Not(HasSubstr(note)));
  // The first half of the lap is not a closed loop.
  const Outcome half = run(closed + " --to +3");
  EXPECT_THAT(half, Ends(2, AllOf(StartsWith("odom evaluate: lap: the lap does not close"),
                                  HasSubstr("cut it to whole laps with --from and --to"))));
  EXPECT_EQ(half.out, "");
}

TEST_F(Report, IsOneWellFormedPageThatNeedsNothingElse) {
  const std::string page = Report::page(" --model paper --model full --title 'R&D <lap>'");
  EXPECT_EQ(markup_fault(page), "");
  EXPECT_THAT(page, StartsWith("<!DOCTYPE html>\n"));
  EXPECT_THAT(page, HasSubstr("<title>R&amp;D &lt;lap&gt;</title>"));
  EXPECT_THAT(page, HasSubstr("width=device-width"));
  for (const char* words : {"mean error of the predicted displacement", "error along", "±3σ",
                            "NEES of (x, y, yaw)", "camera yaw", "±3√S", "wheel_rear_left",
                            "gyro_scale", "cornering_stiffness_front", "odom evaluate --drive"}) {
    EXPECT_THAT(page, HasSubstr(words));
  }
  // The page loads and runs nothing: its only URLs are the names of the formats.
  for (const char* bad : {"<script", "<link", "src=", "href=", "url(", "@import", "nan", "inf\""}) {
    EXPECT_THAT(page, Not(HasSubstr(bad)));
  }
  std::size_t addresses = 0;
  for (std::size_t at = 0; (at = page.find("http", at)) != std::string::npos; ++at) {
    ++addresses;
    EXPECT_TRUE(page.substr(at).starts_with("http://www.w3.org/")) << page.substr(at, 40);
  }
  EXPECT_GT(addresses, 0U);
}

TEST_F(Report, SaysWhatItsColumnsMeanAndWhatIsOfTheWholeDrive) {
  EXPECT_THAT(page(" --model full --model paper --baseline full"),
              AllOf(HasSubstr("distance of the last pose from the reference"),
                    HasSubstr("The baseline is full."), HasSubstr("<dt>NEES</dt><dd>"),
                    Not(HasSubstr("over the whole drive"))));
  EXPECT_THAT(page(" --model paper --closed-loop --dead-reckoning"),
              AllOf(HasSubstr("or from the start of a closed loop"), HasSubstr("camera, left out"),
                    Not(HasSubstr("<dt>35 ms")), Not(HasSubstr("better by"))));
  EXPECT_THAT(page(" --model paper --to +3"),
              HasSubstr("Samples, as paper took them, over the whole drive"));
}

TEST_F(Report, SaysWhichSensorWasNotBelieved) {
  turn_gyro();
  const std::string arguments =
      "--drive lap --dead-reckoning --model kinematic --model full --json --html wrong.html";
  const Outcome outcome = run(arguments + " --config turned.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  // On a circle, the accelerometer or the gyro may be flagged; here either is right.
  const std::string flagged = " \\(IMU\\): contradicts the other sensors";
  // Any source may be gated: in a turn with the wrong sign, wheels seem too fast or too slow.
  const std::string gated =
      "full: [a-z_]* \\([A-Z_]*\\): [0-9]* of its [0-9]* samples \\([0-9]* %\\) were gated";
  // A warning that all models share is given once; any other names its model.
  EXPECT_THAT(outcome.err,
              ContainsRegex("odom evaluate: warning: lap[a-z:, ]*: [a-z_]*" + flagged));
  EXPECT_THAT(outcome.err, ContainsRegex("odom evaluate: warning: lap: " + gated));
  const auto warnings = nlohmann::json::parse(outcome.out)["drives"][0]["warnings"].dump();
  EXPECT_THAT(warnings,
              AllOf(ContainsRegex("\"[a-z: ]*[a-z_]*" + flagged), ContainsRegex("\"" + gated)));
  const std::string page = scratch().text("wrong.html");
  EXPECT_THAT(page, AllOf(ContainsRegex("<p class=\"warning\">[a-z: ]*[a-z_]*" + flagged),
                          ContainsRegex("<p class=\"warning\">" + gated)));

  const Outcome right = run(arguments);
  EXPECT_EQ(right.err, "");
  EXPECT_TRUE(nlohmann::json::parse(right.out)["drives"][0]["warnings"].empty());
  EXPECT_THAT(scratch().text("wrong.html"), Not(HasSubstr("class=\"warning\"")));
}

TEST_F(Report, OpensWithAVerdictAndItsReasons) {
  turn_gyro();
  const auto verdict = [](const std::string& how) {
    const std::string text = page(how);
    EXPECT_LT(text.find("<div class=\"verdict"), text.find("<table>"));
    return text.substr(text.find("<div class=\"verdict"));
  };
  EXPECT_THAT(
      verdict(" --model kinematic --model full"),
      AllOf(StartsWith("<div class=\"verdict good\"><p><b>good</b>: full with the camera."),
            HasSubstr("less than one camera pose"), HasSubstr("smaller than that of kinematic"),
            HasSubstr("Its sigmas fit its errors")));
  EXPECT_THAT(verdict(" --model full --model kinematic --dead-reckoning --baseline full"),
              HasSubstr("by dead reckoning"));
  EXPECT_THAT(run("--drive lap --model full").out,
              ContainsRegex("\nverdict: good: full with the camera\n  good: With the camera its "
                            "position is off by [0-9.]+ mm rms"));
  EXPECT_THAT(verdict(" --model inertial --dead-reckoning --config turned.toml"),
              StartsWith("<div class=\"verdict wrong\">"));
  EXPECT_THAT(run("--drive lap --drive lap/. --model inertial --dead-reckoning "
                  "--config turned.toml")
                  .out,
              ContainsRegex("\n[^\n]*: wrong: Without the camera its position"));
}

TEST_F(Report, IsTheSameEveryTimeAndKeepsItsColumnsOnAPhone) {
  EXPECT_EQ(page(" --model paper"), page(" --model paper"));
  // The page's command is quoted for a shell.
  EXPECT_THAT(page(" --model paper --title \"it's\""), HasSubstr("--title 'it'\\''s'"));
  const std::string page = Report::page(" --model paper --model kinematic_printed");
  EXPECT_THAT(page, HasSubstr("kinematic_<wbr/>printed</th>"));
  // Each cell of a card has its column's name, and each row of figures its label.
  EXPECT_THAT(page, HasSubstr("<td data-name=\"kinematic_printed\">"));
  EXPECT_THAT(page, Not(ContainsRegex("<td class=\"words\">[a-z0-9 ]+ (rms|max|error)[^<]*</td>")));
  EXPECT_THAT(page, HasSubstr("<div class=\"scroll short\">"));  // not scrolled on a printed page
}

TEST_F(Report, HasTheBeatOfARecording) {
  std::string beat = "tick,t,t_woke\n";
  for (int i = 0; i < 100; ++i) {
    const int tick = i < 50 ? i : i + 3;  // three missed
    beat += std::to_string(tick) + ',' + std::to_string(0.005 * tick) + ',' +
            std::to_string(0.005 * tick + (i == 70 ? 0.002 : 0.00002)) + '\n';
  }
  const auto file = scratch().write("beat.csv", beat);
  const odom_beat histogram = read_beat_log(file);
  EXPECT_EQ(histogram.ticks, 100U);
  EXPECT_EQ(histogram.missed, 3U);
  EXPECT_EQ(histogram.max_wakeup_ns, 2'000'000);
  EXPECT_NEAR(percentile_us(histogram.wakeup, 0.5, histogram.max_wakeup_ns), 22.6, 0.1);
  EXPECT_EQ(percentile_us(histogram.wakeup, 1.0, histogram.max_wakeup_ns), 2000.0);

  const std::string page = Report::page(" --model paper --beat " + file.string());
  EXPECT_THAT(page, AllOf(HasSubstr("Wake-up latency"), HasSubstr("largest 2000 us")));
  EXPECT_EQ(markup_fault(page), "");
}

TEST_F(Report, SaysInOneLineWhatIsWrongWithADrive) {
  scratch().write("early.csv", "t,x,y,yaw\n1,0,0,0\n2,1,0,0\n");
  scratch().write("unsorted.csv", "tick,t,t_woke\n2,1,1\n1,2,2\n");
  expect_answers(scratch(), 2, "odom evaluate --drive", R"(
/nonexistent -> /nonexistent: is not a folder
lap --model fancy -> fancy
lap --pose a.csv -> --pose
lap --drive lap --reference a.csv -> --reference: is for one drive only
lap --model paper --baseline best -> odom evaluate: --baseline: no estimate "best"; available: paper
lap --model paper --html /nonexistent/a.html -> /nonexistent/a.html
lap --model paper --reference early.csv -> fewer than two common times
lap --model paper --html a.html --beat unsorted.csv -> unsorted.csv:3: column "tick": the tick
  number does not increase
)");
}

}  // namespace
}  // namespace odomd::tools::report_test
