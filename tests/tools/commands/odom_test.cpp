// The command line of odom as a whole: units in its arguments, and inputs that are not text files,
// which every command refuses immediately, with the fix.
#include "tests/tools/scratch.hpp"

namespace odomd::tools::odom_test {
namespace {

TEST(Odom, PrintsItsVersionAndFailsOnAFullDisk) {
  EXPECT_THAT(must_run("odom --version"), StartsWith("odom "));
  EXPECT_THAT(run_shell("odom --help >/dev/full"),
              Ends(1, "odom: standard output: No space left on device\n"));
}

TEST(Odom, WrongUsageIsOneLineAndStatusTwo) {
  expect_answers(Scratch{}, 2, "odom", R"(
 -> no command given; there are: bridge, camera, dbc,
nonsense -> no command "nonsense"; there are: bridge, camera, dbc,
nonsense --help -> no command "nonsense"
--nonsense -> odom: unknown option "--nonsense": options go after the command that has them; see
  odom --help
)");
}

// odom looks for its companion programs next to itself.
TEST(Odom, SaysWhatToInstallWhereACompanionIsMissing) {
  const Scratch scratch;
  std::filesystem::copy_file(ODOMD_BIN_DIR "/odom", scratch.path("odom"));
  for (const auto& [command, package] :
       {std::pair{" serve", "install the package odom-web"},
        {" bridge", "install the package odom-bridge"},
        {" identify track f.mp4 --aruco 4x4_50 --front 1 --rear 2", "libopencv-dev"},
        {" identify fit --drive somewhere",
         "odom identify fit: fitting needs odom-fit: install the package odom-fit; or install "
         "libceres-dev, and configure and build all: cmake --preset release && cmake --build "
         "--preset release\n"}}) {
    const Outcome outcome = run_shell(scratch.path("odom").string() + command);
    EXPECT_THAT(outcome, Ends(1, HasSubstr(package))) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  }
}

// The camera log and truth of a simulated drive are in other units: each is reported once, without
// the findings that follow from the wrong unit.
TEST(Units, OfPosesAreReportedByReplayAndEvaluate) {
  const Scratch scratch;
  const std::string scale =
      "; awk -F, -v OFS=, -v CONVFMT=%.9g 'NR > 1 { $c *= m; $(c + 1) *= m; $(c + 2) *= r } 1' ";
  simulate(scratch, "--scenario lap --duration 20");
  scratch.must_run("cd drive" + scale + "c=3 m=1000 r=1 camera.csv >camera_mm.csv" + scale +
                   "c=3 m=1 r=57.29578 camera.csv >camera_deg.csv" + scale +
                   "c=2 m=1000 r=1 truth.csv >truth_mm.csv" + scale +
                   "c=2 m=1 r=57.29578 truth.csv >truth_deg.csv");
  const char* const replay =
      "odom replay --config car.toml --can drive.log --out pose.csv --camera ";
  const char* const evaluate = "odom evaluate --pose pose.csv --reference ";
  using Texts = std::vector<const char*>;
  const struct {
    std::string command;
    Texts says;
    Texts not_then;
  } cases[]{
      {std::string(replay) + "camera_mm.csv",
       {"warning: camera: x and y go about 1000 times as far as the wheels", "[W401]"},
       {"scale", "gated", "another drive"}},
      {std::string(replay) + "camera_deg.csv",
       {"warning: camera: yaw turns about 57 times as far as the gyro", "[W403]"},
       {"mounting"}},
      {std::string(replay) + "camera.csv", {}, {"warning"}},
      {std::string(evaluate) + "truth.csv", {}, {"warning"}},
      {std::string(evaluate) + "truth_mm.csv",
       {"truth_mm.csv: x and y go about 1000 times as far as the estimate", "[W401]"},
       {"jumps"}},
      {std::string(evaluate) + "truth_mm.csv --fit-lever-arm", {"[W401]"}, {"too differently"}},
      {std::string(evaluate) + "truth_deg.csv",
       {"truth_deg.csv: yaw turns about 57 times as far as the estimate", "[W403]"},
       {"do not follow", "disagree with"}},
      {"odom evaluate --reference truth.csv --pose truth.csv --pose truth_mm.csv",
       {"truth_mm.csv: x and y go about 1000 times as far as the reference"},
       {"stays at one place"}},
      {"odom evaluate --drive . --model kinematic --reference truth_mm.csv",
       {"drive: truth_mm.csv: x and y go about 1000 times"},
       {"jumps"}},
      {"cp camera_mm.csv camera.csv; cp truth_deg.csv truth.csv; odom evaluate --drive .",
       {"drive: camera: x and y go about 1000 times",
        "drive: ./truth.csv: yaw turns about 57 times"},
       {"another drive"}}};
  std::string err;
  for (const auto& [command, says, not_then] : cases) {
    err = scratch.run("cd drive && " + command).err;
    for (const char* text : says) EXPECT_THAT(err, HasSubstr(text)) << command;
    for (const char* text : not_then) EXPECT_THAT(err, Not(HasSubstr(text))) << command;
  }
  // Without the camera, the gyro's bias is not learnt either.
  EXPECT_EQ(std::ranges::count(err, '\n'), 3) << err;
}

class Inputs : public ::testing::Test {
 protected:
  static std::string folder() {
    static const SharedDrive made{"--scenario circle --laps 1", "d"};
    static const Outcome more = run_shell("cd " + made.scratch.path("").string() +
                                          " && mkfifo pipe && ln -s /dev/zero zero && "
                                          "cp -r d piped && rm piped/drive.log && "
                                          "mkfifo piped/drive.log && "
                                          "gzip -k d/car.toml d/car.dbc d/camera.csv");
    EXPECT_EQ(more.status, 0) << more.err;
    return made.scratch.path("").string();
  }
  /// Runs a command line in the folder for at most ten seconds; returns its error.
  static std::string refused(const std::string& line) {
    const Outcome outcome = run_shell("cd " + folder() + " && timeout 10 " + line);
    EXPECT_EQ(outcome.status, 2) << line << ": " << outcome.err;
    return outcome.err;
  }
};

TEST_F(Inputs, APipeOrADeviceIsRefusedWhereverAFileIsRead) {
  for (const auto& [input, kind] : {std::pair{"pipe", "pipe: is a named pipe; name a file"},
                                    std::pair{"zero", "zero: is a device; name a file"}})
    for (const std::string& line : std::vector<std::string>{
             "odom replay --can d/drive.log --out o --config ",
             "odom replay --can d/drive.log --out o --config d/car.toml --dbc ",
             "odom replay --can d/drive.log --out o --config d/car.toml --camera ",
             "odom evaluate --reference d/truth.csv --pose ",
             "odom evaluate --pose d/truth.csv --reference ", "odom evaluate --drive d --config ",
             "odom plot --out o.svg ", "odom export --mcap o.mcap ", "odom doctor --config ",
             "odom dbc show ", "odom camera send --log ", "odom identify noise --csv ",
             "odom init --can d/drive.log --out o.toml --dbc ", "odomd --check --config "})
      EXPECT_THAT(refused(line + input), HasSubstr(kind)) << line;
  for (const char* line : {"odom evaluate --drive piped", "odom doctor --drive piped",
                           "odom replay --out o --drive piped", "odom export --csv o piped"})
    EXPECT_THAT(refused(line), HasSubstr("piped/drive.log: is a named pipe, not a file"));
}

TEST_F(Inputs, APipeOfTheShellIsRead) {
  must_run("cd " + folder() +
           " && bash -c 'timeout 60 odom replay --can d/drive.log "
           "--config d/car.toml --dbc <(cat d/car.dbc) --camera <(cat d/camera.csv) "
           "--out o'");
}

TEST_F(Inputs, WhatIsPackedIsNamedWithTheCommandThatUnpacksIt) {
  for (const std::string& line : std::vector<std::string>{
           "odomd --check --config d/car.toml",
           "odom replay --config d/car.toml --can d/drive.log --out o --dbc d/car.dbc",
           "odom replay --config d/car.toml --can d/drive.log --out o --camera d/camera.csv"})
    EXPECT_THAT(refused(line + ".gz"), HasSubstr(".gz: is packed; unpack it: gunzip -k d/"));
}

TEST_F(Inputs, ALogInReverseIsNamed) {
  EXPECT_THAT(run_shell("cd " + folder() +
                        " && tac d/drive.log > reverse.log && odom replay "
                        "--config d/car.toml --can reverse.log --out o")
                  .err,
              HasSubstr("the log is in reverse, which tac undoes: "));
}

TEST_F(Inputs, EmptyValuesAndNumbersWithUnitsAreRefused) {
  for (const char* line : {"odom pose --shm ''", "odom status --socket ''", "odom export ''",
                           "odom replay --drive d --out o --camera ''"})
    EXPECT_THAT(refused(line), HasSubstr(": is empty; give a value, or leave it out")) << line;
  EXPECT_THAT(refused("odom camera send --pose 1,2,90deg"),
              AllOf(HasSubstr("--pose = 1,2,90deg"), HasSubstr("without a unit")));
}

TEST_F(Inputs, DrivesAreTakenWithAndWithoutTheirOption) {
  const auto out = [](const std::string& line) {
    const Outcome outcome = run_shell("cd " + folder() + " && " + line);
    EXPECT_LE(outcome.status, 1) << line << ": " << outcome.err;
    return outcome.out;
  };
  EXPECT_NE(out("odom replay --drive d --out -"), "");
  for (const auto& [before, after] : {std::pair{"odom replay --out - ", ""},
                                      {"odom doctor ", ""},
                                      {"odom evaluate --model kinematic ", ""},
                                      {"odom export --csv - ", ""}})
    EXPECT_EQ(out(before + std::string("--drive d") + after),
              out(before + std::string("d") + after));
  EXPECT_THAT(refused("odom evaluate nowhere"), HasSubstr("nowhere: is not a folder"));
  EXPECT_THAT(refused("odom replay --out - nowhere"), HasSubstr("nowhere: is not a folder"));
}

TEST_F(Inputs, ADriveIsReplayedLikeItsFiles) {
  const auto replayed = [](const std::string& options) {
    return must_run("cd " + folder() + " && odom replay --out - " + options);
  };
  const std::string whole = replayed("--config d/car.toml --can d/drive.log --camera d/camera.csv");
  EXPECT_EQ(replayed("--drive d"), whole);
  EXPECT_EQ(replayed("--drive d --config d/car.toml"), whole);
  EXPECT_NE(replayed("--drive d --model kinematic"), whole);
  EXPECT_THAT(refused("odom replay --drive d --recording d --out o"), HasSubstr("excludes"));
}

}  // namespace
}  // namespace odomd::tools::odom_test
