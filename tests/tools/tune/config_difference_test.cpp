#include "tools/tune/config_difference.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace odomd::tools::config_difference_test {
namespace {

daemon::Config config_of(const std::string& more) {
  return daemon::parse_config(
      "[can.signals]\n"
      "wheel_rear = { message = \"W\", signal = \"V\", unit = \"m/s\", bus = \"can0\" }\n" +
          more,
      "car.toml");
}

std::string difference(const std::string& one, const std::string& other,
                       const std::vector<Parameter>& tuned = {}) {
  const std::string dbc = "[can]\ndbc = \"car.dbc\"\n";
  return config_difference(config_of(one + dbc), config_of(other + dbc), tuned);
}

TEST(ConfigDifference, IsOfKeysThatAPoseDependsOn) {
  EXPECT_EQ(difference("", ""), "");
  EXPECT_EQ(difference("[filter]\nwheel_slip = 0.03\n", "[filter]\nwheel_slip = 0.04\n"),
            "filter.wheel_slip (0.03, 0.04)");
  EXPECT_EQ(difference("[imu]\nposition = [0.1, 0]\n", "[imu]\nposition = [0.1, 0.2]\n"),
            "imu.position[1] (0, 0.2)");
  EXPECT_EQ(difference("[shm]\nname = \"/a\"\n[initial]\npose = [1.0, 2.0, 3.0]\n", ""), "");
}

TEST(ConfigDifference, CountsWhatIsLeftOutAsItsDefault) {
  EXPECT_EQ(difference("[filter]\nwindow = 0.25\n", ""), "");
  EXPECT_EQ(difference("[filter]\nwindow = 0.3\n", ""), "filter.window (0.3, 0.25)");
  EXPECT_EQ(difference("[realtime]\nperiod = 0.005\n", "[filter]\nmodel = \"full\"\n"), "");
}

TEST(ConfigDifference, LeavesOutWhatIsTunedAndNamesAFew) {
  const std::string some =
      "[filter]\nwindow = 0.3\nwheel_slip = 0.1\ngyro_bias_walk = 1e-3\ngyro_scale_walk = 1e-3\n"
      "accel_bias_walk = 1\n";
  const std::string text = difference(some, "");
  EXPECT_EQ(text.substr(text.rfind(')') + 1), " and 2 more");
  EXPECT_EQ(difference("[filter]\nwindow = 0.3\n", "", {{.key = "filter.window"}}), "");
}

}  // namespace
}  // namespace odomd::tools::config_difference_test
