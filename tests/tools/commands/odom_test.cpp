// The command line of odom as a whole.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::odom_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Odom, PrintsItsVersion) {
  const Outcome outcome = run_shell("odom --version");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, StartsWith("odom "));
}

TEST(Odom, WrongUsageIsOneLineAndStatusTwo) {
  for (const char* line : {"odom", "odom nonsense", "odom --nonsense", "odom nonsense --help"}) {
    const Outcome outcome = run_shell(line);
    EXPECT_EQ(outcome.status, 2) << line;
    EXPECT_EQ(outcome.out, "") << line;
    EXPECT_THAT(outcome.err, StartsWith("odom: ")) << line;
    EXPECT_THAT(outcome.err, HasSubstr("see odom --help")) << line;
    EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << line;
  }
}

TEST(Odom, AFullDiskIsFailedWork) {
  EXPECT_THAT(run_shell("odom --help >/dev/full"),
              Ends(1, "odom: standard output: No space left on device\n"));
}

TEST(OdomBridge, RefusesRatesAndNamesThatCannotBe) {
  for (const char* wrong : {"--rate nan", "--rate 0", "--rate=-3", "--rate inf", "--frame-base ''",
                            "--frame-map 'my map'", "--frame-odom map"}) {
    const Outcome outcome = run_shell(std::string("odom bridge --ros --duration 0.1 ") + wrong);
    EXPECT_EQ(outcome.status, 2) << wrong << ": " << outcome.err;
    EXPECT_LT(outcome.err.size(), 200U) << outcome.err;
  }
}

}  // namespace
}  // namespace odomd::tools::odom_test
