// odom identify fit as a command: a simulated drive gives the values of its configuration;
// unsuitable drives are refused with the reason.
#include <nlohmann/json.hpp>

#include "tests/gtest.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::fit_command_test {
namespace {

std::string in(const Scratch& scratch, const std::string& command) {
  return "cd " + scratch.path("").string() + " && " + command;
}

class FitCommand : public testing::Test {
 protected:
  FitCommand() {
    const Outcome drive = run_shell(in(scratch_, "odom sim --duration 16 --out lap"));
    if (drive.status != 0) throw std::runtime_error(drive.err);
  }
  [[nodiscard]] Outcome run(const std::string& command) const {
    return run_shell(in(scratch_, command));
  }
  void expect_refused(const std::string& command, const std::string& says) const {
    tools::expect_refused(in(scratch_, ""), {{command, HasSubstr(says)}});
  }
  Scratch scratch_;
};

TEST_F(FitCommand, WritesWhatTheDriveDeterminesAndLeavesTheRest) {
  std::string most =
      "odom identify fit --untried --config lap/car.toml --drive lap --write lap/car.toml";
  for (const char* name :
       {"stiffness_front", "stiffness_rear", "relaxation_length", "bend_front", "bend_rear",
        "load_arm", "track_width", "steering_scale", "steering_delay", "steering_lag",
        "accel_scale", "accel_latency", "imu_x", "imu_y", "imu_yaw", "wheel_slip", "camera_yaw"})
    most += std::string(" --fix ") + name;
  const Outcome outcome = run(most);
  EXPECT_THAT(outcome, Ends(0, HasSubstr("pass 1 of")));
  EXPECT_THAT(outcome.out, HasSubstr("gyro bias"));
  const std::string written = contents(scratch_.path("lap/car.toml"));
  EXPECT_THAT(written, HasSubstr("odom identify fit:"));
  EXPECT_THAT(written, HasSubstr("cornering_stiffness_front = 20.0\n"));  // was fixed
  EXPECT_THAT(outcome.err, Not(HasSubstr("same speed")));
  EXPECT_EQ(run("odom replay --config lap/car.toml --can lap/drive.log --out pose.csv").status, 0);
}

TEST_F(FitCommand, OneSpeedDoesNotSeparateTyresAndSteering) {
  std::string most = "odom identify fit --untried --quiet --config lap/car.toml --drive lap --json";
  for (const char* name : {"relaxation_length", "bend_front", "bend_rear", "load_arm", "imu_yaw",
                           "accel_scale", "wheel_slip", "camera_x", "steering_lag"})
    most += std::string(" --fix ") + name;
  const Outcome outcome = run(most);
  EXPECT_THAT(outcome, Ends(0, HasSubstr("turns are driven at much the same speed")));
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_FALSE(json["details"]["parameters"]["steering_scale"]["determined"]);
  EXPECT_LT(json["details"]["turns"]["speed_variety"], 0.1);
}

// Between the command and the wheels there are 60 ms of dead time and a lag of 100 ms.
TEST_F(FitCommand, WritesTheActuatorOfASteeringCommand) {
  ASSERT_EQ(run("odom sim --scenario exercise --duration 40 --servo --seed 4 --out servo").status,
            0);
  std::string most = "odom identify fit --untried --quiet --drive servo --json";
  for (const char* name : {"yaw_inertia", "relaxation_length", "bend_front", "bend_rear",
                           "load_arm", "track_width", "accel_scale", "accel_latency", "imu_x",
                           "imu_y", "imu_yaw", "wheel_slip", "camera_x", "camera_yaw"})
    most += std::string(" --fix ") + name;
  const Outcome outcome = run(most);
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

TEST_F(FitCommand, SaysInOneLineWhatIsWrongWithADrive) {
  const std::string fit = "odom identify fit --quiet --config lap/car.toml ";
  expect_refused(fit + "--drive nowhere", "nowhere: is not a folder");
  expect_refused(fit + "--drive lap/drive.log", "lap/drive.log: is a file; give the folder");
  expect_refused(fit + "--drive lap --to 9.9", "ten seconds");
  expect_refused(fit + "--drive lap --from 7", "ten are needed");
  const auto expect_refused_with = [&](const std::string& change, const std::string& options,
                                       const std::string& says) {
    ASSERT_EQ(run("rm -rf bad && cp -r lap bad && cd bad && " + change).status, 0);
    expect_refused(fit + options + " --drive bad", says);
  };
  expect_refused_with(
      "printf 't_arrival,t_capture,x,y,yaw,sigma_x,sigma_y\\n1,1,0,0,0,1,1\\n' "
      "> camera.csv",
      "", "sigma_yaw");
  for (const char* rows :
       {"1760000001,0,0,0\\n1760000002,nan,0,0", "1760000002,0,0,0\\n1760000001,0,0,0"})
    expect_refused_with(std::string("printf 't,x,y,yaw\\n") + rows + "\\n' > truth.csv",
                        "--use-reference", "truth.csv");
  expect_refused_with("sed -i 's/,17/,18/g;s/^17/18/' camera.csv", "", "while the log lasts");
  expect_refused_with("(sed '2s/#.*/#/' ../lap/drive.log; echo '(1'; echo '(1') > drive.log",
                      "--strict", "drive.log:");
  ASSERT_EQ(run("sed '/^yaw_rate/s/}/, scale = -1.0 }/' lap/car.toml > lap/left.toml").status, 0);
  expect_refused("odom identify fit --config lap/left.toml --drive lap",
                 "lap: yaw_rate: turns the other way than the camera; check the sign of "
                 "can.signals.yaw_rate.scale [W301]");
  expect_refused("odom identify latency --config lap/left.toml --can lap/drive.log",
                 "can.signals.yaw_rate.scale");
  ASSERT_EQ(run("sed -i /^steering/d lap/car.toml").status, 0);
  expect_refused(fit + "--drive lap", "steering");
}

TEST_F(FitCommand, TakesTheLogUnderEitherNameAndSaysWhatItLookedFor) {
  const std::string fit = "odom identify fit --quiet ";
  ASSERT_EQ(run("mv lap/drive.log lap/can.log").status, 0);
  // The log is found: the error is about the duration.
  expect_refused(fit + "--drive lap --from 7", "ten are needed");
  ASSERT_EQ(run("odom export lap --mcap lap.mcap").status, 0);
  ASSERT_EQ(run("mv lap/can.log lap/bus.log").status, 0);
  expect_refused(fit + "--drive lap", "lap: has no drive.log and no can.log");
  ASSERT_EQ(run("mv lap/bus.log lap/drive.log && rm lap/camera.csv").status, 0);
  expect_refused(fit + "--drive lap", "lap: has no camera.csv to fit to; use its truth.csv");
}

TEST_F(FitCommand, TakesTheConfigurationOfTheDriveWhereNoneIsNamed) {
  const std::string fit = "odom identify fit --quiet ";
  // The configuration is found: the error is about the duration.
  expect_refused(fit + "--drive lap --from 7", "ten are needed");
  ASSERT_EQ(run("cp -r lap lap2 && sed -i s/^mass.*/mass=4.0/ lap2/car.toml").status, 0);
  expect_refused(fit + "--drive lap --drive lap2", "differ; give the car's configuration");
  ASSERT_EQ(run("rm lap/car.toml").status, 0);
  expect_refused(fit + "--drive lap", "lap: has no car.toml; give");
}

}  // namespace
}  // namespace odomd::tools::fit_command_test
