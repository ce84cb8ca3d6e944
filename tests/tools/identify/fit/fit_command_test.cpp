// odom identify fit as a command: a simulated drive gives the values of its configuration;
// unsuitable drives are refused with the reason.
#include "tests/tools/scratch.hpp"

namespace odomd::tools::fit_command_test {
namespace {

class FitCommand : public testing::Test {
 protected:
  FitCommand() { simulate(scratch_, "--duration 16", "lap"); }
  /// Fits without a trial; the parameters in `fixed` stay as configured.
  [[nodiscard]] Outcome fit(const std::string& options,
                            const std::vector<std::string>& fixed) const {
    std::string line = "odom identify fit --untried " + options;
    for (const std::string& name : fixed) line += " --fix " + name;
    return scratch_.run(line);
  }
  Scratch scratch_;
};

TEST_F(FitCommand, WritesWhatTheDriveDeterminesAndLeavesTheRest) {
  const Outcome outcome = fit(
      "--config lap/car.toml --drive lap --write lap/car.toml",
      {"stiffness_front", "stiffness_rear", "relaxation_length", "bend_front", "bend_rear",
       "load_arm", "track_width", "steering_scale", "steering_delay", "steering_lag", "accel_scale",
       "accel_latency", "imu_x", "imu_y", "imu_yaw", "wheel_slip", "camera_yaw"});
  EXPECT_THAT(outcome, Ends(0, HasSubstr("pass 1 of")));
  EXPECT_THAT(outcome.out, HasSubstr("gyro bias"));
  const std::string written = scratch_.text("lap/car.toml");
  EXPECT_THAT(written, HasSubstr("odom identify fit:"));
  EXPECT_THAT(written, HasSubstr("cornering_stiffness_front = 20.0\n"));  // was fixed
  EXPECT_THAT(outcome.err, Not(HasSubstr("same speed")));
  scratch_.must_run("odom replay --config lap/car.toml --can lap/drive.log --out pose.csv");
}

TEST_F(FitCommand, OneSpeedDoesNotSeparateTyresAndSteering) {
  const Outcome outcome = fit("--quiet --config lap/car.toml --drive lap --json",
                              {"relaxation_length", "bend_front", "bend_rear", "load_arm",
                               "imu_yaw", "accel_scale", "wheel_slip", "camera_x", "steering_lag"});
  EXPECT_THAT(outcome, Ends(0, HasSubstr("turns have much the same speed")));
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_FALSE(json["details"]["parameters"]["steering_scale"]["determined"]);
  EXPECT_LT(json["details"]["turns"]["speed_variety"], 0.1);
}

// Between the command and the wheels there are 60 ms of dead time and a lag of 100 ms.
TEST_F(FitCommand, WritesTheActuatorOfASteeringCommand) {
  simulate(scratch_, "--scenario exercise --duration 40 --servo --seed 4", "servo");
  const Outcome outcome = fit("--quiet --drive servo --json",
                              {"yaw_inertia", "relaxation_length", "bend_front", "bend_rear",
                               "load_arm", "track_width", "accel_scale", "accel_latency", "imu_x",
                               "imu_y", "imu_yaw", "wheel_slip", "camera_x", "camera_yaw"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  double delay = 0.0, lag = 0.0;
  const auto found = nlohmann::json::parse(outcome.out);
  for (const auto& value : found["values"]) {
    if (value.value("key", "") == "steering.delay") delay = value["value"];
    if (value.value("key", "") == "steering.lag") lag = value["value"];
  }
  EXPECT_NEAR(delay, 0.06, 0.03);
  EXPECT_NEAR(lag, 0.1, 0.03);
  EXPECT_NEAR(delay + lag, 0.16, 0.015);
}

TEST_F(FitCommand, ReportsAFaultyDriveInOneLine) {
  expect_answers(scratch_, 2, "odom identify fit --quiet --config lap/car.toml --drive", R"(
nowhere -> nowhere: is not a folder
lap/drive.log -> lap/drive.log: is a file; give the folder
lap --to 9.9 -> ten seconds
lap --from 7 -> ten are needed
)");
  // Changes to a copy of the drive, and what the error about each says.
  const struct {
    const char *change, *options, *says;
  } cases[]{{"printf 't_arrival,t_capture,x,y,yaw,sigma_x,sigma_y\\n1,1,0,0,0,1,1\\n' > camera.csv",
             "", "sigma_yaw"},
            {"printf 't,x,y,yaw\\n1760000001,0,0,0\\n1760000002,nan,0,0\\n' > truth.csv",
             "--use-reference", "truth.csv"},
            {"printf 't,x,y,yaw\\n1760000002,0,0,0\\n1760000001,0,0,0\\n' > truth.csv",
             "--use-reference", "truth.csv"},
            {"sed -i 's/,17/,18/g;s/^17/18/' camera.csv", "", "while the log lasts"},
            {"(sed '2s/#.*/#/' ../lap/drive.log; echo '(1'; echo '(1') > drive.log", "--strict",
             "drive.log:"}};
  for (const auto& [change, options, says] : cases) {
    scratch_.must_run(std::string("rm -rf bad && cp -r lap bad && cd bad && ") + change);
    expect_answers(scratch_, 2, "odom identify fit --quiet --config lap/car.toml --drive bad",
                   (std::string(options) + " -> " + says).c_str());
  }
  scratch_.must_run("sed '/^yaw_rate/s/}/, scale = -1.0 }/' lap/car.toml > lap/left.toml");
  scratch_.must_run("sed /^steering/d lap/car.toml > lap/unsteered.toml");
  expect_answers(scratch_, 2, "odom identify", R"(
fit --config lap/left.toml --drive lap -> lap: yaw_rate: turns the other way than the camera; check
  the sign of can.signals.yaw_rate.scale [W301]
latency --config lap/left.toml --can lap/drive.log -> can.signals.yaw_rate.scale
fit --quiet --config lap/unsteered.toml --drive lap -> steering
)");
}

// If all files are found, the error is about the duration.
TEST_F(FitCommand, AcceptsTheFilesOfADriveAndNamesMissingOnes) {
  scratch_.must_run(
      "cp -r lap by_other_name && mv by_other_name/drive.log by_other_name/can.log && "
      "cp -r lap logless && mv logless/drive.log logless/bus.log && "
      "cp -r lap blind && rm blind/camera.csv && cp -r lap bare && rm bare/car.toml && "
      "cp -r lap heavy && sed -i s/^mass.*/mass=4.0/ heavy/car.toml && "
      "odom export by_other_name --mcap lap.mcap");
  expect_answers(scratch_, 2, "odom identify fit --quiet --drive", R"(
lap --from 7 -> ten are needed
by_other_name --from 7 -> ten are needed
logless -> logless: has no drive.log and no can.log
blind -> blind: has no camera.csv to fit to; use its truth.csv
lap --drive heavy -> differ; give the car's configuration
bare -> bare: has no car.toml; give
)");
}

}  // namespace
}  // namespace odomd::tools::fit_command_test
