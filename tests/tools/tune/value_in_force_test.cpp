#include "tools/tune/value_in_force.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>

#include "tools/config_patch/config_patch.hpp"

namespace odomd::tools::value_in_force_test {
namespace {

const std::string text =
    "[can]\ndbc = \"car.dbc\"\n[can.signals]\n"
    "wheel_rear = { message = \"W\", signal = \"V\", unit = \"m/s\" }\n";

daemon::Config config_of(const std::string& words) {
  return daemon::parse_config(words, "car.toml");
}

// Whatever the program takes for a key, to write it there changes nothing, and to write another
// number there is what is in force then.
TEST(ValueInForce, IsWhatTheKeySaysAndWithoutItTheDefault) {
  for (const char* key : {"filter.window",
                          "filter.camera_gate",
                          "filter.gyro_bias_walk",
                          "filter.gyro_scale_walk",
                          "filter.accel_bias_walk",
                          "filter.wheel_scale_walk",
                          "filter.steering_offset_walk",
                          "filter.stiffness_scale_walk",
                          "filter.front_angle_error",
                          "filter.side_slip_error",
                          "filter.wheel_radius_error",
                          "filter.wheel_slip",
                          "camera.max_latency",
                          "imu.yaw",
                          "imu.roll_gradient",
                          "imu.pitch_gradient",
                          "steering.delay",
                          "steering.lag",
                          "can.signals.wheel_rear.scale",
                          "can.signals.wheel_rear.offset",
                          "can.signals.wheel_rear.latency",
                          "can.signals.wheel_rear.sigma",
                          "can.signals.wheel_rear.timeout"}) {
    const auto before = value_in_force(config_of(text), key);
    ASSERT_TRUE(before) << key;
    const double other = *before > 0.0 ? 1.01 * *before : 0.01;
    const std::array patch{ConfigValue{key, other, ""}};
    const auto after = value_in_force(config_of(patched(text, "car.toml", patch)), key);
    ASSERT_TRUE(after) << key;
    EXPECT_NEAR(*after, other, 1e-9 * other) << key;
  }
}

TEST(ValueInForce, OfListsIsOfTheirElements) {
  const daemon::Config config = config_of(
      "[imu]\nposition = [0.25, 0.5]\n[camera]\nlever_arm = [1, 2, 3]\n[filter]\n"
      "paper_q = [4, 5, 6]\npaper_r = [7, 8]\n" +
      text);
  EXPECT_EQ(value_in_force(config, "imu.position[1]"), 0.5);
  EXPECT_EQ(value_in_force(config, "camera.lever_arm[2]"), 3.0);
  EXPECT_EQ(value_in_force(config, "filter.paper_q[1]"), 5.0);
  EXPECT_EQ(value_in_force(config, "filter.paper_r[0]"), 7.0);
}

TEST(ValueInForce, OfALimitIsNothingWhereThereIsNone) {
  const std::string car =
      "[vehicle]\nmass = 3\nfront_axle = 0.1\nrear_axle = 0.1\nyaw_inertia = 0.03\n"
      "cornering_stiffness_front = 20\ncornering_stiffness_rear = 20\ntrack_width = 0.16\n";
  const daemon::Config linear = config_of(car + text);
  const daemon::Config limited =
      config_of("[steering]\nrate_limit = 3\n" + car + "grip_front = 9\ngrip_rear = 8\n" + text);
  const std::pair<const char*, double> limits[] = {
      {"vehicle.grip_front", 9.0}, {"vehicle.grip_rear", 8.0}, {"steering.rate_limit", 3.0}};
  for (const auto& [key, limit] : limits) {
    EXPECT_FALSE(value_in_force(linear, key)) << key;
    EXPECT_EQ(value_in_force(limited, key), limit) << key;
  }
}

TEST(ValueInForce, OfADeadBandIsNothingWhereTheFilterChoosesIt) {
  const char* const key = "can.signals.wheel_rear.dead_band";
  EXPECT_FALSE(value_in_force(config_of(text), key));
  const std::array patch{ConfigValue{key, 0.3, ""}};
  EXPECT_EQ(value_in_force(config_of(patched(text, "car.toml", patch)), key), 0.3);
}

TEST(ValueInForce, IsNothingForWhatIsNoNumberOfTheConfiguration) {
  for (const char* key : {"filter.nonsense", "can.signals", "can.signals.wheel_rear",
                          "can.signals.yaw_rate.sigma", "can.signals.wheel_rear.message", ""})
    EXPECT_FALSE(value_in_force(config_of(text), key)) << key;
}

}  // namespace
}  // namespace odomd::tools::value_in_force_test
