// odom plot as a command.
#include <chrono>
#include <map>
#include <thread>

#include "daemon/core/record.hpp"
#include "tests/tools/drives.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/report/figures.hpp"

namespace odomd::tools::plot_test {
namespace {

class Plot : public ::testing::Test {
 protected:
  Plot() {
    std::string rows =
        "t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,steering,accel_x,accel_y,"
        "gyro_bias\n";
    for (int i = 0; i < 200; ++i) {
      const std::string t = std::to_string(100.0 + 0.005 * i);
      const std::string v = i == 77 ? "9.5" : "1.5";  // one spike
      rows += t + ",0.1,0.2,0.3," + v + ",0,0.1,0.01,0.01,0.02,tracking,0.1,0.2,0.3,0.004\n";
    }
    scratch_.write("pose.csv", rows);
    Trajectory truth = wavy_drive(0.0, 1.0, 0.01);
    for (auto& point : truth.points) point.t_ns += 100'000'000'000;
    scratch_.write("truth.csv", csv_of(truth));
  }
  [[nodiscard]] Outcome run(const std::string& arguments) const {
    return scratch_.run("odom plot " + arguments);
  }
  // The SVG of a plot that must succeed.
  [[nodiscard]] std::string svg_of(const std::string& arguments) const {
    const Outcome outcome = run(arguments + " --out -");
    EXPECT_THAT(outcome, Ends(0, ""));
    EXPECT_EQ(markup_fault(outcome.out), "");
    EXPECT_THAT(outcome.out, AllOf(StartsWith("<svg xmlns="), Not(HasSubstr("nan"))));
    return outcome.out;
  }
  Scratch scratch_;
};

TEST_F(Plot, DrawsTheTrajectoryByDefault) {
  EXPECT_THAT(svg_of("pose.csv --reference truth.csv --title 'A&B'"),
              AllOf(HasSubstr(">reference<"), HasSubstr(">pose<"), HasSubstr("A&amp;B")));
}

TEST_F(Plot, DrawsEveryQuantityThatAPoseFileHas) {
  for (const auto& [what, says] : {std::pair{"speed", "v_x [m/s]"},
                                   {"lateral_speed", "v_y [m/s]"},
                                   {"yaw_rate", "[deg/s]"},
                                   {"steering", "front wheels [deg]"},
                                   {"acceleration", "along y"},
                                   {"sigma", "sigma_yaw [deg]"},
                                   {"calibrations", "gyro_bias"}})
    EXPECT_THAT(svg_of(std::string("pose.csv --what ") + what),
                AllOf(HasSubstr(says), Not(HasSubstr("wheel_scale"))));
  EXPECT_THAT(svg_of("pose.csv --what heading --reference truth.csv"), HasSubstr(">reference<"));
  EXPECT_THAT(svg_of("pose.csv --what speed"), HasSubstr(">8<"));  // the axis includes the spike
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != text.npos; at = text.find(what, at + 1)) ++found;
  return found;
}

// All calibrations, two per row, fit on a page in the format 1 : sqrt(2). Calibrations with a sigma
// have bands. If the reference is a simulated drive, the true values are drawn too.
TEST_F(Plot, FitsAllCalibrationsOnAPage) {
  std::string rows = record_header();
  for (std::int64_t t_ns : {1'000'000'000, 2'000'000'000}) {
    daemon::TickRecord record;
    for (std::size_t i = 0; i < 3; ++i) daemon::calibration_sigma(record.details, i) = 0.5;
    append_record_row(rows, record, t_ns);
  }
  scratch_.write("all.csv", rows);
  simulate(scratch_, "--config-only --seed 3", "sim");
  scratch_.write("sim/truth.csv", scratch_.text("truth.csv"));
  for (const bool simulated : {false, true}) {
    const Outcome outcome = run(std::string("all.csv --what calibrations --out - --reference ") +
                                (simulated ? "sim/truth.csv" : "truth.csv"));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::string& svg = outcome.out;
    EXPECT_THAT(svg, AllOf(HasSubstr(">gyro_bias<"), HasSubstr(">grip<"),
                           HasSubstr("translate(500.0 0) scale(0.5)")));
    EXPECT_LE(std::stod(svg.substr(svg.find(" height=\"") + 9)), 1414.0);
    EXPECT_EQ(count(svg, ">±3σ<"), 3U);
    EXPECT_EQ(count(svg, ">true<"), simulated ? daemon::calibrations.size() - 1 : 0U);
  }
}

// The simulator states errors, such as a wheel radius error; they are converted to calibrations.
TEST_F(Plot, ReadsTheTrueCalibrationsOfASimulatedDrive) {
  const auto file = scratch_.path("plant.json");
  EXPECT_TRUE(true_calibrations(file.parent_path()).empty());
  const std::string most =
      R"("gyro_bias":0.1,"gyro_scale_error":0.02,"accel_bias_x":0.3,"accel_bias_y":-0.4,
         "wheel_radius_error":0.25,"steering_offset":0.05,"stiffness_error_front":-0.2,
         "stiffness_error_rear":0.1,"gyro_latency":0.006,"wheel_latency":0.007,
         "steering_delay":0.02,"steering_lag":0.03,"steering_latency":0.008)";
  for (const double commanded : {0.0, 1.0}) {
    scratch_.write("plant.json", R"({"truth":{)" + most + R"(,"steering_commanded":)" +
                                     std::to_string(commanded) + "}}");
    const std::map<std::string, double> expected{
        {"gyro_bias", 0.1},        {"gyro_scale", 1.02},
        {"accel_bias_x", 0.3},     {"accel_bias_y", -0.4},
        {"wheel_scale", 0.8},      {"steering_offset", 0.05},
        {"stiffness_scale", 0.95}, {"gyro_latency", 0.006},
        {"wheel_latency", 0.007},  {"steering_latency", 0.008 + commanded * 0.05}};
    const Calibrations found = true_calibrations(file.parent_path());
    EXPECT_EQ(found.size(), expected.size());
    for (const auto& [name, value] : expected) EXPECT_NEAR(found.at(name), value, 1e-12) << name;
  }
  scratch_.write("plant.json", R"({"experiment":{}})");
  EXPECT_TRUE(true_calibrations(file.parent_path()).empty());
  for (const char* other : {"{", R"({"truth":{"gyro_bias":1}})", R"({"truth":7})"}) {
    scratch_.write("plant.json", other);
    const std::string plot = "pose.csv --reference truth.csv --out - --what ";
    EXPECT_THAT(run(plot + "calibrations"),
                Ends(2, HasSubstr("plant.json: is not a plant.json of odom sim: ")))
        << other;
    EXPECT_EQ(run(plot + "speed").status, 0) << other;
  }
}

TEST_F(Plot, OverlaysFilesAndStacksQuantities) {
  scratch_.write("other.csv", scratch_.text("pose.csv"));
  EXPECT_THAT(svg_of("pose.csv other.csv --what speed --what heading"),
              AllOf(HasSubstr(">pose<"), HasSubstr(">other<"), HasSubstr(">Speed<"),
                    HasSubstr(">Heading<")));
  // Without a common time, each file begins at 0.
  scratch_.write("early.csv", csv_of(wavy_drive(0.0, 1.0, 0.01)));
  EXPECT_THAT(
      run("pose.csv early.csv --what heading --out -"),
      Ends(0, "odom plot: warning: the files have no time in common; each begins at 0 s\n"));
}

TEST_F(Plot, DrawsTheInnovationsOfAReplay) {
  simulate(scratch_, "--scenario lap --standstill 0.5 --duration 3");
  scratch_.must_run("odom replay --drive drive --out /dev/null --innovations nu.csv");
  EXPECT_GT(read_innovations(scratch_.path("nu.csv")).size(), 1500U);
  EXPECT_THAT(svg_of("nu.csv --what innovation"),
              AllOf(HasSubstr(">yaw_rate<"), HasSubstr("innovation [deg/s]"),
                    HasSubstr(">camera yaw<"), HasSubstr("±3√S")));
}

TEST_F(Plot, FollowsARunningDaemon) {
  const std::string segment = scratch_.path("pose").string();
  SlowDaemon daemon(segment, 5'000'000);
  daemon.pose.vx = 1.0;
  std::jthread beat([&daemon](const std::stop_token& stop) {
    for (; !stop.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds{5}))
      daemon.tick();
  });
  const std::string svg =
      svg_of("--for 0.5 --shm " + segment + " --what trajectory --what speed --what beat");
  EXPECT_THAT(svg, AllOf(HasSubstr("v_x [m/s]"), HasSubstr("Wake-up latency")));
}

TEST_F(Plot, ReportsErrorsInOneLine) {
  scratch_.write("bad.csv", "t,x,y,yaw\n1,0,0,0\n0,1,1,1\n");
  scratch_.write("nan.csv", "t,x,y,yaw,steering\n1,0,0,0,nan\n");
  expect_answers(scratch_, 2, "odom plot", R"(
--out x.svg -> A pose file or --for is required
--out x.svg pose.csv --what speeds -> "speeds" cannot be drawn; available: trajectory|
--out x.svg /nonexistent.csv -> /nonexistent.csv: no such file
--out x.svg truth.csv --what speed -> truth.csv: has no columns "vx", "vy", "yaw_rate"; use a file
  of odom replay
--out x.svg pose.csv --what innovation -> pose.csv:1: no column "source"
--out x.svg pose.csv --what beat -> pose.csv:1: no column "tick"
--out x.svg --for 1 --what innovation -> the daemon does not keep innovations
--out x.svg bad.csv -> bad.csv:3: column "t": the time runs backwards
--out x.svg nan.csv --what steering -> nan.csv:2: column "steering": "nan"
--out x.jpg pose.csv -> pictures end in .svg or .png
)");
  EXPECT_FALSE(std::filesystem::exists(scratch_.path("x.svg")));
}

TEST(InnovationChart, LeavesAGapInTheBandWithoutSamples) {
  std::vector<estimator::Judgement> judgements;
  for (int i = 0; i < 200; ++i)
    judgements.push_back({.source = estimator::Source::yaw_rate,
                          .verdict = estimator::Verdict::fused,
                          .degrees = 1,
                          .innovation = {0.01},
                          .time_ns = 10'000'000LL * (i < 100 ? i : i + 500),
                          .variance = {1e-4}});
  const auto charts = innovation_charts(judgements, 0);
  ASSERT_EQ(charts.size(), 1U);
  const auto& band = charts[0].bands[0].points;
  EXPECT_EQ(std::ranges::count_if(band, [](const auto& p) { return std::isnan(p.low); }), 1);
  EXPECT_EQ(band.size(), judgements.size() + 1);
}

TEST(InnovationFile, ReadsBackWhatWasWritten) {
  const Scratch scratch;
  estimator::Judgement judgement{.source = estimator::Source::camera,
                                 .verdict = estimator::Verdict::gated,
                                 .degrees = 3,
                                 .innovation = {0.25, -0.5, 0.125},
                                 .squared_ratio = 17.5,
                                 .test_ratio = 1.5,
                                 .time_ns = 1'760'000'000'123'456'789,
                                 .variance = {0.25, 4.0, 0.0625}};
  std::string text = innovation_header();
  append_innovation_rows(text, judgement);
  const auto read = read_innovations(scratch.write("nu.csv", text));
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].source, judgement.source);
  EXPECT_EQ(read[0].verdict, judgement.verdict);
  EXPECT_EQ(read[0].time_ns, judgement.time_ns);
  EXPECT_EQ(read[0].innovation, judgement.innovation);
  EXPECT_EQ(read[0].variance, judgement.variance);
  EXPECT_EQ(read[0].squared_ratio, judgement.squared_ratio);
  EXPECT_THAT(message_of([&] {
                (void)read_innovations(scratch.write(
                    "bad.csv", innovation_header() + "1,gyro,fused,1,0,0,0,1,0,0,0\n"));
              }),
              HasSubstr(R"(bad.csv:2: column "source": "gyro" is unknown)"));
  EXPECT_THAT(
      message_of([&] { (void)read_innovations(scratch.write("e.csv", innovation_header())); }),
      HasSubstr("e.csv: has no rows; only the full filter tests samples"));
}

}  // namespace
}  // namespace odomd::tools::plot_test
