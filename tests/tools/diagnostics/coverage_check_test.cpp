#include "tools/diagnostics/coverage_check.hpp"
#include "tests/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/drives.hpp"

namespace odomd::tools::coverage_check_test {
namespace {

using diagnostics::Named;
using ::testing::Optional;

const Trajectory truth = wavy_drive(0.0, 20.0, 0.01);

TEST(CoverageCheck, IsOfTheWayThatIsDriven) {
  EXPECT_FALSE(check_coverage(truth, wavy_drive(0.0, 20.0, 0.005)));
  EXPECT_FALSE(check_coverage(truth, wavy_drive(1.0, 20.0, 0.005)));
  EXPECT_THAT(check_coverage(truth, wavy_drive(5.0, 15.0, 0.005)),
              Optional(Named("estimate_covers_part",
                             "10.0 s and 9.6 m of the reference's 20.0 s and 19.7 m")));
  Trajectory hole = wavy_drive(0.0, 20.0, 0.005);
  std::erase_if(hole.points, [](const TrajectoryPoint& point) {
    return point.t_ns > 4'000'000'000 && point.t_ns < 9'000'000'000;
  });
  EXPECT_THAT(check_coverage(truth, hole), Optional(Named("estimate_covers_part", "15.0 s")));
}

TEST(CoverageCheck, HasNoneOfRowsThatAreFarApart) {
  EXPECT_FALSE(check_coverage(truth, wavy_drive(0.0, 20.0, 1.0)));
}

TEST(CoverageCheck, HasNoneOfAReferenceThatGoesOnWhileTheCarStands) {
  Trajectory longer = truth;
  for (int i = 1; i <= 3000; ++i) {  // 30 s, trembling
    TrajectoryPoint point = truth.points.back();
    point.t_ns += 10'000'000LL * i;
    point.pose.x += i % 2 == 0 ? 0.06 : -0.06;
    longer.points.push_back(point);
  }
  EXPECT_FALSE(check_coverage(longer, truth));
}

}  // namespace
}  // namespace odomd::tools::coverage_check_test
