// Findings about a drive's units, headings and coverage.
#include <numbers>

#include "tests/diagnostics.hpp"
#include "tests/tools/drives.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools::trajectory_checks_test {
namespace {

using diagnostics::Named;
using ::testing::Optional;

constexpr double degree = std::numbers::pi / 180.0;

Trajectory in_units(double metre, double radian) {
  Trajectory drive = moved_by({3.0, -2.0, 1.0}, wavy_drive(0.0, 20.0, 0.03));
  for (auto& point : drive.points)
    point.pose = {metre * point.pose.x, metre * point.pose.y, radian * point.pose.yaw};
  return drive;
}

// The distance from a wheel and the yaw from a gyro, each with a scale error.
Trajectory driven(double wheel = 1.05, double gyro = 0.97) {
  Trajectory drive = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : drive.points)
    point.pose = {wheel * 1e-9 * static_cast<double>(point.t_ns), 0.0, gyro * point.pose.yaw};
  return drive;
}

diagnostics::Diagnostics units(const Trajectory& poses, const Trajectory& driven) {
  return check_units("camera", poses.points, {.trajectory = driven});
}

const auto millimetres = Named("positions_in_millimetres", "about 1000 times as far as the wheels");
const auto degrees = Named("yaw_in_degrees", "about 57 times as far as the gyro");

TEST(UnitCheck, FindsMillimetresAndDegreesUnlessWheelsOrGyroAreWrong) {
  const struct {
    double metre, radian;
    ::testing::Matcher<const diagnostics::Diagnostics&> found;
    double wheel = 1.05, gyro = 0.97;
  } cases[]{{1.0, 1.0, IsEmpty()},
            {1.0, -1.0, IsEmpty()},
            {30.0, 1.0, IsEmpty()},
            {1000.0, 1.0, ElementsAre(millimetres)},
            {100.0, 1.0, ElementsAre(Named("positions_in_centimetres"))},
            {1.0, 1.0 / degree, ElementsAre(degrees)},
            {1000.0, 1.0 / degree, ElementsAre(millimetres, degrees)},
            {1.0, 1.0, IsEmpty(), 0.001, 1.0},
            {1.0, 1.0, IsEmpty(), 1.0, degree},
            {1.0, 1.0, IsEmpty(), 3.6, 1.0 / degree}};
  for (const auto& [metre, radian, found, wheel, gyro] : cases)
    EXPECT_THAT(units(in_units(metre, radian), driven(wheel, gyro)), found)
        << metre << ' ' << radian << ' ' << wheel << ' ' << gyro;
  Trajectory wrapped = in_units(1.0, 1.0 / degree);
  for (auto& point : wrapped.points) point.pose.yaw = std::remainder(point.pose.yaw, 360.0);
  EXPECT_THAT(units(wrapped, driven()), ElementsAre(degrees));
}

TEST(UnitCheck, ToleratesAFewOutliers) {
  Trajectory good = in_units(1.0, 1.0), bad = in_units(1000.0, 1.0 / degree);
  for (std::size_t i = 0; i < good.points.size(); i += 50) {
    good.points[i].pose = {900.0, -900.0, 3.0};
    bad.points[i].pose = {0.0, 0.0, 180.0};
  }
  EXPECT_THAT(units(good, driven()), IsEmpty());
  EXPECT_THAT(units(bad, driven()), ElementsAre(millimetres, degrees));
}

TEST(UnitCheck, ComparesPosesWithAFilterThatJumps) {
  Trajectory estimate = wavy_drive(0.0, 20.0, 0.01);
  for (std::size_t i = 0; i < estimate.points.size(); ++i)
    estimate.points[i].reset_count = std::floor(0.05 * static_cast<double>(i));
  EXPECT_THAT(units(in_units(1000.0, 1.0), estimate), ElementsAre(millimetres));
}

TEST(UnitCheck, TakesCameraPosesInAnyOrder) {
  std::vector<estimator::CameraPose> poses;
  for (const TrajectoryPoint& point : in_units(1000.0, 1.0).points) {
    estimator::CameraPose pose;
    pose.capture_ns = point.t_ns;
    pose.x = point.pose.x;
    pose.y = point.pose.y;
    pose.yaw = point.pose.yaw;
    poses.insert(poses.size() % 3 == 0 ? poses.begin() : poses.end(), pose);
  }
  EXPECT_THAT(check_units("camera", poses, {.trajectory = driven()}), ElementsAre(millimetres));
}

TEST(UnitCheck, FindsNothingIfTheCarHardlyMoves) {
  EXPECT_THAT(units(in_units(1000.0, 1.0 / degree), driven(0.01, 0.01)), IsEmpty());
  EXPECT_THAT(check_units("camera", std::span<const TrajectoryPoint>{}, {.trajectory = driven()}),
              IsEmpty());
}

const Trajectory truth = wavy_drive(0.0, 20.0, 0.01);

TEST(CoverageCheck, MeasuresTheDistanceDriven) {
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
  // Evenly spaced rows are not gaps, even 1 s apart.
  EXPECT_FALSE(check_coverage(truth, wavy_drive(0.0, 20.0, 1.0)));
}

TEST(CoverageCheck, IgnoresAReferenceThatContinuesAtRest) {
  Trajectory longer = truth;
  for (int i = 1; i <= 3000; ++i) {  // 30 s with jitter
    TrajectoryPoint point = truth.points.back();
    point.t_ns += 10'000'000LL * i;
    point.pose.x += i % 2 == 0 ? 0.06 : -0.06;
    longer.points.push_back(point);
  }
  EXPECT_FALSE(check_coverage(longer, truth));
}

Trajectory with_yaw(double factor, double offset) {
  Trajectory drive = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : drive.points) point.pose.yaw = factor * point.pose.yaw + offset;
  return drive;
}

TEST(HeadingCheck, SuspectsDegreesAndClockwiseTurnsButNotReversingOrDrifting) {
  EXPECT_FALSE(check_headings(with_yaw(1.0, 0.0)));
  EXPECT_FALSE(check_headings(with_yaw(1.0, std::numbers::pi)));  // backwards
  EXPECT_FALSE(check_headings(with_yaw(1.0, 0.7)));               // with a slip angle of 40°
  EXPECT_THAT(check_headings(with_yaw(180.0 / std::numbers::pi, 0.0)),
              Optional(Named("headings_off_path")));
  EXPECT_THAT(check_headings(with_yaw(-1.0, 0.0)), Optional(Named("headings_off_path")));
  // A car that hardly moves.
  Trajectory standing = with_yaw(-1.0, 0.0);
  for (auto& point : standing.points) point.pose.x = point.pose.y = 0.0;
  EXPECT_FALSE(check_headings(standing));
}

}  // namespace
}  // namespace odomd::tools::trajectory_checks_test
