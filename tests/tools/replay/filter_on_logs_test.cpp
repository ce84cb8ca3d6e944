// The filter on replayed drives: prediction, slides, and the paper author's own run.
#include <fmt/format.h>
#include <odom/odom.h>
#include <bit>
#include <memory>

#include "daemon/core/pipeline.hpp"
#include "tests/estimator/golden.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools::filter_on_logs_test {
namespace {

struct Horizon {
  int ticks;
  double bar;  ///< [m]
  double worst = 0.0;
};

/// Largest errors over every tenth tick of a lap, except its start.
std::array<Horizon, 2> worst_of_a_lap(const std::string& speed) {
  const Scratch scratch;
  Drive drive = read_drive(
      {.folder = simulate(scratch, "--scenario lap --speed " + speed + " --duration 25 --seed 5")});
  drive.config.model = estimator::Model::full;
  const std::int64_t period_ns = drive.config.realtime.period_ns;
  const auto pipeline =
      std::make_unique<daemon::Pipeline>(drive.config, drive.databases, drive.buses, true);
  auto frame = drive.frames.begin();

  std::array<Horizon, 2> horizons{{{7, 2e-4}, {20, 2e-3}}};
  const auto ahead = std::make_unique<estimator::Filter>(pipeline->state().filter);
  replay(
      *pipeline, period_ns, [&] { return frame == drive.frames.end() ? nullptr : &*frame++; },
      drive.cameras,
      [&](const daemon::TickRecord& record) {
        if (record.pose.tick % 10 != 0 || record.pose.tick < 1000) return;
        for (Horizon& horizon : horizons) {
          const std::int64_t time_ns = record.pose.time_ns + horizon.ticks * period_ns;
          *ahead = pipeline->state().filter;
          // No sample arrives meanwhile: the filter holds its inputs.
          const estimator::Estimate own = step(*ahead, time_ns);
          odom_pose predicted;
          ASSERT_EQ(odom_predict(&record.pose, time_ns, &predicted), ODOM_OK);
          horizon.worst =
              std::max(horizon.worst, std::hypot(predicted.x - own.map.x, predicted.y - own.map.y));
        }
      });
  return horizons;
}

class Prediction : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Lap, Prediction, testing::Values("1", "1.5", "2.5"),
                         [](const auto& speed) {
                           std::string name = speed.param;
                           std::ranges::replace(name, '.', '_');
                           return name;
                         });

TEST_P(Prediction, IsTheFiltersOwn) {
  for (const Horizon& horizon : worst_of_a_lap(GetParam())) {
    EXPECT_GT(horizon.worst, 0.0);
    EXPECT_LE(horizon.worst, horizon.bar) << horizon.ticks << " ticks ahead";
  }
}

TEST(Slide, TheCameraIsFollowed) {
  // Worse rules exceed the bars: 0.3 and 0.6 m rms if the camera must confirm the filter's motion;
  // 14, 5 and 4 m for the full-size cars if the only remaining wheels spin; 6.6 m if a wheel that
  // spins up is trusted until the slip is detected.
  for (const auto& [options, bar] :
       {std::pair{"--scenario lap --speed 3 --friction 0.6", 0.25},
        {"--scenario slalom --speed 3 --friction 0.5", 0.25},
        {"--car bmw_320i --speed 14 --friction 0.6 --duration 60 --seed 5", 0.8},
        {"--car saloon --speed 13 --friction 0.5 --duration 60 --seed 6", 0.8},
        {"--car saloon --speed 13 --friction 0.5 --duration 60 --seed 5", 0.8},
        {"--car saloon --speed 13 --friction 0.6 --duration 60 --seed 5", 0.8}}) {
    const Scratch scratch;
    const std::string drive = scratch.path("drive").string();
    run_shell("odom sim --out " + drive + " " + options);  // some leave their track, and report it
    const auto full = nlohmann::json::parse(must_run("odom evaluate --model full --json --drive " +
                                                     drive))["drives"][0]["estimates"][0];
    EXPECT_LT(full["position"]["rms"].get<double>(), bar) << options;
  }
}

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
      const std::array ours{p.motion.v_x, p.motion.v_y, p.motion.yaw_rate,
                            p.pose.x,     p.pose.y,     p.pose.yaw};
      for (std::size_t k = 0; k < ours.size(); ++k)
        worst = std::max(worst, std::abs(ours[k] - golden[i].expected[k]));
    }
    EXPECT_LT(worst, 1e-9);
  }
}

}  // namespace
}  // namespace odomd::tools::filter_on_logs_test
