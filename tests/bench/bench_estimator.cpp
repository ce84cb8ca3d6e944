// What the filters cost: the paper's predict and correct alone, a whole tick of each model, and a
// late camera pose.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "estimator/filter.hpp"
#include "estimator/paper_ekf.hpp"

namespace odomd::estimator {
namespace {

constexpr std::int64_t period_ns = 5'000'000;

struct Step {
  Eigen::Vector2d u;
  Eigen::Vector2d z;
};

/// A slalom at 1.5 m/s, so that no branch predictor or constant folding has an easy life.
std::array<Step, 1024> slalom() {
  std::array<Step, 1024> steps{};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double t = 0.005 * static_cast<double>(i);
    const double delta = 0.3 * std::sin(2.0 * t);
    const double speed = 1.5 + 0.3 * std::sin(0.7 * t);
    steps[i] = {{delta, 0.21 * std::cos(0.7 * t)}, {speed * std::tan(delta) / 0.26, speed}};
  }
  return steps;
}

void paper_predict_and_correct(benchmark::State& state) {
  const auto steps = slalom();
  PaperEkf ekf;
  std::size_t i = 0;
  for (auto _ : state) {
    const Step& step = steps[i++ % steps.size()];
    predict(ekf, step.u);
    correct(ekf, step.z);
    benchmark::DoNotOptimize(ekf.x.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(paper_predict_and_correct);

void whole_tick(benchmark::State& state, Model model) {
  const auto steps = slalom();
  Filter filter = make_filter(model, {});
  set_initial_pose(filter, {});
  std::int64_t now = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    const Step& s = steps[i++ % steps.size()];
    now += period_ns;
    add(filter, Measurement{Source::steering, now, s.u[0], 0.02});
    add(filter, Measurement{Source::accel_x, now, s.u[1], 0.3});
    add(filter, Measurement{Source::yaw_rate, now, s.z[0], 0.03});
    add(filter, Measurement{Source::wheel_rear_left, now, s.z[1], 0.05});
    add(filter, Measurement{Source::wheel_rear_right, now, s.z[1], 0.05});
    Estimate e = step(filter, now);
    benchmark::DoNotOptimize(e);
  }
}
BENCHMARK_CAPTURE(whole_tick, paper, Model::paper);
BENCHMARK_CAPTURE(whole_tick, kinematic, Model::kinematic);

/// A camera pose that is `latency` ticks late, with the tick that takes it in.
void camera_pose(benchmark::State& state) {
  const std::int64_t latency = state.range(0) * period_ns - 1;
  FilterSettings settings;
  settings.camera_max_latency_s = 2.0;
  Filter filter = make_filter(Model::paper, settings);
  set_initial_pose(filter, {});
  std::int64_t now = period_ns;
  add(filter, Measurement{Source::wheel_rear, now, 0.0, 0.05});
  for (int i = 0; i < 300; ++i) {
    now += period_ns;
    step(filter, now);
  }
  for (auto _ : state) {
    now += period_ns;
    const std::optional<Verdict> verdict =
        add(filter, CameraPose{now - latency, now, 0.0, 0.0, 0.0, 0.01, 0.01, 0.01});
    if (verdict != Verdict::fused) {
      state.SkipWithError("the pose was not fused");
      break;
    }
    Estimate e = step(filter, now);
    benchmark::DoNotOptimize(e);
  }
}
BENCHMARK(camera_pose)->Arg(1)->Arg(8)->Arg(40)->Arg(250);

}  // namespace
}  // namespace odomd::estimator
