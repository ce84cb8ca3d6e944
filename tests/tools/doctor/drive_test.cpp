// Mistakes of wiring, configuration and clocks, made in simulated drives: each is named once with
// the key that corrects it, and nothing is found in the drives as they are.
#include <cctype>
#include <string>
#include <vector>

#include "tests/tools/doctor/edited_drive.hpp"

namespace odomd::tools::doctor::edited_drive {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;

const std::string accel = R"(unit = "m/s2",)";
const std::string across = R"("AccY", unit = "m/s2")";

class SoundDrive : public ::testing::TestWithParam<const char*> {};

TEST_P(SoundDrive, GivesNothing) {
  Drive drive = drive_with({}, GetParam());
  EXPECT_THAT(found_in(drive), IsEmpty());
  drive.reference.reset();
  drive.cameras.clear();
  EXPECT_THAT(found_in(drive), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    Of, SoundDrive,
    ::testing::Values("--scenario slalom --duration 22", "--scenario lap --laps 1",
                      "--scenario circle --duration 20", "--scenario stop-and-go --duration 30",
                      "--scenario parking --laps 1", "--car saloon --duration 40",
                      "--car bmw_320i --scenario lap --laps 1",
                      "--car ford_escort --scenario slalom --duration 40",
                      "--car vw_vanagon --scenario slalom --duration 40",
                      "--scenario road --duration 60 --seed 2"),
    [](const auto& test) {
      std::string name;
      for (const char c : std::string{test.param})
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
      return name;
    });

TEST(Wiring, WithAWrongSignNamesTheScale) {
  expect_only(found_in(drive_with({{gyro, gyro + ", scale = -1"}})), "wrong_sign",
              "can.signals.yaw_rate.scale");
  expect_only(found_in(drive_with({{steering, steering + ", scale = -1"}})), "wrong_sign",
              "can.signals.steering.scale");
  expect_only(found_in(drive_with({{across, across + ", scale = -1"}})), "wrong_sign",
              "can.signals.accel_y.scale");
}

TEST(Wiring, WithExchangedSignalsNamesThem) {
  expect_only(found_in(drive_with(exchange("\"AccX\"", "\"AccY\""))), "axes_swapped",
              "can.signals.accel_x");
  std::vector<Edit> sides = exchange("\"WheelFrontLeft\"", "\"WheelFrontRight\"");
  const std::vector<Edit> rear = exchange("\"WheelRearLeft\"", "\"WheelRearRight\"");
  sides.insert(sides.end(), rear.begin(), rear.end());
  expect_only(found_in(drive_with(sides)), "left_right_swapped", "can.signals.wheel_front_left");
  // It shows in tight turns that are driven gently.
  expect_only(found_in(drive_with(exchange(R"("WHEELS_FRONT", signal = "WheelFront)",
                                           R"("WHEELS_REAR", signal = "WheelRear)"),
                                  "--scenario parking --laps 1")),
              "front_rear_swapped", "can.signals.wheel_front_left");
}

TEST(Wiring, InAnotherUnitNamesTheSignal) {
  expect_only(found_in(drive_with({{accel, accel + " scale = 0.102,"}})), "wrong_unit",
              "can.signals.accel_x");
  expect_only(found_in(drive_with({{speed, speed + " scale = 3.6,"}})), "wrong_unit",
              "can.signals.wheel_front_left");
  expect_only(found_in(drive_with({{gyro, gyro + ", scale = 57.3"}})), "wrong_unit",
              "can.signals.yaw_rate");
}

TEST(Camera, OfAnotherMapOrUnitIsNamed) {
  Drive drive = drive_with({});
  const std::vector<estimator::CameraPose> poses = drive.cameras;
  for (auto& pose : drive.cameras) {
    pose.x *= 1e3;
    pose.y *= 1e3;
  }
  expect_only(found_in(drive), "positions_in_millimetres", "camera");
  drive.cameras = poses;
  for (auto& pose : drive.cameras) {
    pose.y = -pose.y;
    pose.yaw = -pose.yaw;
  }
  expect_only(found_in(drive), "camera_mirrored", "camera");
  drive.cameras = poses;
  for (auto& pose : drive.cameras) pose.x += 5.0;
  expect_only(found_in(drive), "initial_pose_elsewhere", "[initial] pose");
}

TEST(Camera, ByAnotherClockIsNamedEvenIfThereIsNoPoseForIt) {
  Drive drive = drive_with({});
  drive.config.initial_pose.reset();
  for (estimator::CameraPose& pose : drive.cameras) {
    pose.capture_ns += 1'000'000'000'000;
    pose.arrival_ns += 1'000'000'000'000;
  }
  EXPECT_THAT(found_in(drive), ::testing::Contains(Named("camera_outside_log")));
}

TEST(Configuration, InOtherUnitsIsNamedOnce) {
  EXPECT_THAT(found_in(drive_with({{"mass = 2.985", "mass = 2985"}})),
              ElementsAre(Named("mass_unlike_a_car", "mass in kilograms")));
  EXPECT_THAT(found_in(drive_with({{"axle = 0.175", "axle = 175"}, {"axle = 0.085", "axle = 85"}})),
              ElementsAre(Named("mass_unlike_a_car", "front_axle and rear_axle in metres")));
}

TEST(Configuration, WithGuessesOfInitSaysHowMany) {
  const Drive drive = drive_with({{"mass = 2.985", "mass = 2.985  # UNSURE: a guess"}});
  EXPECT_THAT(examine_drive(drive).note, StartsWith("1 line of edited.toml is marked UNSURE"));
}

TEST(Configuration, WithoutARoleNamesIt) {
  EXPECT_THAT(found_in(drive_with({{"yaw_rate = {", "#"}})),
              ElementsAre(Named("role_not_mapped", "yaw_rate")));
}

TEST(Configuration, OfAnotherCarIsNamedOnce) {
  Drive drive = drive_with({});
  for (can::Frame& frame : drive.frames) frame.id += 0x100;
  EXPECT_THAT(found_in(drive), ElementsAre(Named("other_database", "can.dbc")));
}

TEST(Traffic, ThatIsMissingIsNamed) {
  Drive drive = drive_with({});
  drive.frames.clear();
  EXPECT_THAT(found_in(drive), ElementsAre(Named("no_frames")));
}

TEST(Traffic, WithoutAMessageNamesItAndNothingElse) {
  Drive drive = drive_with({});
  std::erase_if(drive.frames, [](const can::Frame& frame) { return frame.id == 0x1A3; });
  EXPECT_THAT(found_in(drive), ElementsAre(Named("message_missing", "steering")));
}

}  // namespace
}  // namespace odomd::tools::doctor::edited_drive
