// What a client predicts from a published pose, against the filter's own propagation of the same
// instant: laps of the simulator through the pipeline.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <odom/odom.h>

#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools::prediction_test {
namespace {

struct Horizon {
  int ticks;
  double bar;  ///< [m]
  double worst = 0.0;
};

/// Every tenth tick of a lap, from two seconds after the start on.
std::array<Horizon, 2> worst_of_a_lap(const std::string& speed) {
  const Scratch scratch;
  const std::string folder = scratch.path("lap").string();
  const Outcome drive = run_shell("odom sim --scenario lap --speed " + speed +
                                  " --duration 25 --seed 5 --out " + folder);
  EXPECT_EQ(drive.status, 0) << drive.err;
  daemon::Config config = daemon::load_config(folder + "/car.toml");
  config.model = estimator::Model::full;
  diagnostics::Diagnostics warnings;
  const std::vector<can::Database> databases = daemon::load_databases(config, warnings);
  can::BusNames buses;
  const std::vector<std::string> logs{folder + "/drive.log"};
  can::MergedLog log(logs, buses);
  const auto cameras = read_camera_log(folder + "/camera.csv").poses;
  const auto pipeline = std::make_unique<daemon::Pipeline>(config, databases, buses.all(), true);

  std::array<Horizon, 2> horizons{{{7, 2e-4}, {20, 2e-3}}};
  const auto ahead = std::make_unique<estimator::Filter>(pipeline->state().filter);
  replay(
      *pipeline, config.realtime.period_ns, [&log] { return log.next(); }, cameras,
      [&](const daemon::TickRecord& record) {
        if (record.pose.tick % 10 != 0 || record.pose.tick < 1000) return;
        for (Horizon& horizon : horizons) {
          const std::int64_t time_ns =
              record.pose.time_ns + horizon.ticks * config.realtime.period_ns;
          *ahead = pipeline->state().filter;
          // No sample comes in on the way: the filter goes on with its inputs held.
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

}  // namespace
}  // namespace odomd::tools::prediction_test
