// The filter on replayed drives: prediction, wheel slip, slides.
#include <functional>
#include <memory>
#include <variant>

#include <odom/odom.h>
#include <nlohmann/json.hpp>

#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "estimator/full_filter.hpp"
#include "tests/tools/monitored_drive.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools::filter_on_logs_test {
namespace {

using estimator::Estimate;
using estimator::FullFilter;
using estimator::Judgement;
using estimator::Measurement;
using estimator::Pose2;
using estimator::Source;
using estimator::Verdict;

struct Horizon {
  int ticks;
  double bar;  ///< [m]
  double worst = 0.0;
};

/// Largest errors over every tenth tick of a lap, except its start.
std::array<Horizon, 2> worst_of_a_lap(const std::string& speed) {
  const Scratch scratch;
  const std::string folder =
      simulate(scratch, "--scenario lap --speed " + speed + " --duration 25 --seed 5");
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
    const Outcome outcome = run_shell("odom evaluate --model full --json --drive " + drive);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto full = nlohmann::json::parse(outcome.out)["drives"][0]["estimates"][0];
    EXPECT_LT(full["position"]["rms"].get<double>(), bar) << options;
  }
}

constexpr std::int64_t second_ns = 1'000'000'000;

struct SlipCase {
  const char* name;
  std::vector<Source> wheels;
  std::function<double(double)> slipping;  ///< reading in slip from the true one
};

class WheelSlip : public testing::TestWithParam<SlipCase> {
 protected:
  static constexpr std::int64_t begins_s = 10;  // in the second bend
  static constexpr std::int64_t lasts_s = 2;

  void SetUp() override {
    const Scratch scratch;
    const std::string folder = simulate(scratch, "--scenario lap --laps 1 --seed 5");
    config_ = daemon::load_config(folder + "/car.toml");
    drive_ = load_drive(config_, folder + "/drive.log", "");
    begin_ns_ = drive_.events.front().tick_ns + begins_s * second_ns;
    end_ns_ = begin_ns_ + lasts_s * second_ns;
  }

  [[nodiscard]] static bool slips(Source source) {
    return std::ranges::find(GetParam().wheels, source) != GetParam().wheels.end();
  }

  struct Run {
    Pose2 when_it_begins;
    Pose2 when_it_ends;
    Pose2 at_the_end;
    int slipping_fused = 0;
    int slipping_left_out = 0;
    int others_fused = 0;  ///< other wheels, during the slip
    int others_left_out = 0;
    int fused_afterwards = 0;  ///< of these wheels, from 0.1 s after the slip on
    int left_out_afterwards = 0;
  };

  [[nodiscard]] Run run(bool with_slip) const {
    FullFilter filter(daemon::filter_settings(config_));
    filter.set_initial_pose({});
    Run run;
    std::size_t next = 0;
    for (std::int64_t tick_ns = drive_.events.front().tick_ns; next < drive_.events.size();
         tick_ns += drive_.period_ns) {
      for (; next < drive_.events.size() && drive_.events[next].tick_ns <= tick_ns; ++next) {
        Measurement sample = std::get<Measurement>(drive_.events[next].sample);
        if (with_slip && slips(sample.source) && sample.time_ns >= begin_ns_ &&
            sample.time_ns < end_ns_)
          sample.value = GetParam().slipping(sample.value);
        (void)filter.add(sample);
      }
      const Estimate estimate = filter.step(tick_ns);
      for (const Judgement& judgement : filter.judgements()) count(judgement, tick_ns, run);
      run.at_the_end = estimate.map;
      if (tick_ns <= begin_ns_) run.when_it_begins = estimate.map;
      if (tick_ns <= end_ns_) run.when_it_ends = estimate.map;
    }
    return run;
  }

 private:
  void count(const Judgement& judgement, std::int64_t tick_ns, Run& run) const {
    const bool fused = judgement.verdict == Verdict::fused;
    if (!estimator::is_wheel(judgement.source)) return;
    if (tick_ns > begin_ns_ + second_ns / 20 && tick_ns < end_ns_) {
      if (slips(judgement.source))
        ++(fused ? run.slipping_fused : run.slipping_left_out);
      else
        ++(fused ? run.others_fused : run.others_left_out);
    }
    if (slips(judgement.source) && tick_ns > end_ns_ + second_ns / 10)
      ++(fused ? run.fused_afterwards : run.left_out_afterwards);
  }

  daemon::Config config_;
  MonitoredDrive drive_;
  std::int64_t begin_ns_ = 0;
  std::int64_t end_ns_ = 0;
};

TEST_P(WheelSlip, IsLeftOutAndThePoseStaysGood) {
  const Run sound = run(false);
  const Run slipped = run(true);
  ASSERT_GT(std::hypot(sound.when_it_ends.x - sound.when_it_begins.x,
                       sound.when_it_ends.y - sound.when_it_begins.y),
            1.0);

  EXPECT_GT(slipped.slipping_left_out, 150);
  EXPECT_EQ(slipped.slipping_fused, 0);
  EXPECT_GT(slipped.others_fused, 20 * slipped.others_left_out);
  EXPECT_GT(slipped.fused_afterwards, 20 * slipped.left_out_afterwards);

  for (const auto& [a, b] : {std::pair{sound.when_it_ends, slipped.when_it_ends},
                             std::pair{sound.at_the_end, slipped.at_the_end}}) {
    EXPECT_LT(std::hypot(a.x - b.x, a.y - b.y), 0.06);
    EXPECT_LT(std::abs(a.yaw - b.yaw), 0.01);
  }
}

INSTANTIATE_TEST_SUITE_P(
    AWheel, WheelSlip,
    testing::Values(
        SlipCase{"Locked", {Source::wheel_rear_left}, [](double) { return 0.0; }},
        SlipCase{"LockedInFront", {Source::wheel_front_right}, [](double) { return 0.0; }},
        SlipCase{"Spinning", {Source::wheel_rear_right}, [](double speed) { return 1.5 * speed; }},
        SlipCase{"DrivenAxleSpinning",
                 {Source::wheel_rear_left, Source::wheel_rear_right},
                 [](double speed) { return 2.0 * speed; }}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace odomd::tools::filter_on_logs_test
