// Interfaces without a CAN controller. Real controllers are tested in the lab.
#include "can_protocol/sources/controller.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::controller_test {
namespace {

TEST(Controller, IsNoneWhereThereIsNoSuchInterfaceOrItIsNotCanAndNothingIsSaidAboutIt) {
  testing::internal::CaptureStderr();
  EXPECT_FALSE(read_controller("no-such-bus"));
  EXPECT_FALSE(read_controller("lo"));
  EXPECT_FALSE(read_controller(""));
  EXPECT_FALSE(read_controller("an interface's name is never as long as this one"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Controller, HealthHasANameForEveryValue) {
  EXPECT_EQ(name_of(ControllerHealth::error_active), "error_active");
  EXPECT_EQ(name_of(ControllerHealth::bus_off), "bus_off");
  EXPECT_EQ(name_of(ControllerHealth::sleeping), "sleeping");
}

}  // namespace
}  // namespace odomd::can::controller_test
