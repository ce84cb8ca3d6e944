// The filter on replayed drives: prediction and slides.
#include <memory>

#include <odom/odom.h>
#include <nlohmann/json.hpp>

#include "daemon/core/pipeline.hpp"
#include "tests/tools/scratch.hpp"
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
  // Worse rules exceed the bars, with 0.3 and 0.6 m rms if the camera must confirm the filter's
  // motion; 14, 5 and 4 m for the full-size cars if the only remaining wheels spin; 6.6 m if a
  // wheel that spins up is trusted until the slip is detected.
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

}  // namespace
}  // namespace odomd::tools::filter_on_logs_test
