// The paper author's own run, sent over the bus: odom replay with --model paper reproduces the
// output of his filter.
#include <fmt/format.h>

#include <bit>

#include "tests/estimator/golden.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools::golden_replay_test {
namespace {

constexpr std::string_view bus =
    "BO_ 256 ALL: 32 X\n"
    " SG_ Steering : 0|64@1- (1,0) [0|0] \"rad\" X\n"
    " SG_ AccX : 64|64@1- (1,0) [0|0] \"m/s2\" X\n"
    " SG_ YawRate : 128|64@1- (1,0) [0|0] \"rad/s\" X\n"
    " SG_ Speed : 192|64@1- (1,0) [0|0] \"m/s\" X\n"
    "SIG_VALTYPE_ 256 Steering : 2;\n"
    "SIG_VALTYPE_ 256 AccX : 2;\n"
    "SIG_VALTYPE_ 256 YawRate : 2;\n"
    "SIG_VALTYPE_ 256 Speed : 2;\n";
constexpr std::string_view car =
    "[can]\ndbc = \"car.dbc\"\n[can.signals]\n"
    "steering = { message = \"ALL\", signal = \"Steering\", unit = \"rad\" }\n"
    "accel_x = { message = \"ALL\", signal = \"AccX\", unit = \"m/s2\" }\n"
    "yaw_rate = { message = \"ALL\", signal = \"YawRate\", unit = \"rad/s\" }\n"
    "wheel_rear = { message = \"ALL\", signal = \"Speed\", unit = \"m/s\" }\n";

std::string log_line(std::int64_t time_ns, const estimator::testing::GoldenRow& row) {
  std::string line =
      fmt::format("({}.{:09}) can0 100##0", time_ns / 1'000'000'000, time_ns % 1'000'000'000);
  for (const double value : {row.steering, row.accel_x, row.yaw_rate, row.speed}) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (unsigned shift = 0; shift < 64; shift += 8)
      line += fmt::format("{:02X}", (bits >> shift) & 0xFFU);
  }
  return line + '\n';
}

// Inputs stamped on the grid's ticks or slightly before them reach the same ticks.
TEST(GoldenReplay, AgreesWithTheAuthorsFilterFromTheFirstTick) {
  const auto golden = estimator::testing::read_golden();
  const Scratch scratch;
  scratch.write("car.dbc", bus);
  scratch.write("car.toml", car);
  for (const std::int64_t early_ns : {0, 1, 1'000'000}) {
    constexpr std::int64_t first_ns = 1'760'000'000'000'000'000;
    constexpr std::int64_t period_ns = 5'000'000;
    std::string log;
    std::int64_t time_ns = first_ns;
    for (const auto& row : golden) {
      log += log_line(time_ns - early_ns, row);
      time_ns += period_ns;
    }
    const auto drive = scratch.write("drive.log", log);
    const auto out = scratch.path("pose.csv");
    must_run("odom replay --model paper --config " + scratch.path("car.toml").string() + " --can " +
             drive.string() + " --out " + out.string());

    const Trajectory poses = read_trajectory(out);
    ASSERT_EQ(poses.points.size(), golden.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < golden.size(); ++i) {
      const TrajectoryPoint& p = poses.points[i];
      ASSERT_EQ(p.t_ns, first_ns + static_cast<std::int64_t>(i) * period_ns);
      const std::array ours{p.motion.vx, p.motion.vy, p.motion.yaw_rate,
                            p.pose.x,    p.pose.y,    p.pose.yaw};
      for (std::size_t k = 0; k < ours.size(); ++k)
        worst = std::max(worst, std::abs(ours[k] - golden[i].expected[k]));
    }
    EXPECT_LT(worst, 1e-9);
  }
}

}  // namespace
}  // namespace odomd::tools::golden_replay_test
