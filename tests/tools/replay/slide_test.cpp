// A simulated car that slides and spins under a camera: the filter follows the camera, as wheels
// and tyres say little then.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::slide_test {
namespace {

using ::testing::HasSubstr;

TEST(Slide, TheCameraIsFollowed) {
  // Where the camera must have seen the filter's motion, the position is off by 0.3 and 0.6 m rms.
  for (const std::string scenario : {"lap --friction 0.6", "slalom --friction 0.5"}) {
    const Scratch scratch;
    const std::string drive = scratch.path("drive").string();
    const Outcome simulated =
        run_shell("odom sim --speed 3 --out " + drive + " --scenario " + scenario);
    EXPECT_THAT(simulated.err, HasSubstr("the car has left its track"));
    const Outcome outcome = run_shell("odom evaluate --model full --json --drive " + drive);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto full = nlohmann::json::parse(outcome.out)["drives"][0]["estimates"][0];
    EXPECT_LT(full["position"]["rms"].get<double>(), 0.25) << scenario;
  }
}

}  // namespace
}  // namespace odomd::tools::slide_test
