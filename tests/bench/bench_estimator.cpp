// Cost of the filters: the paper's predict and correct alone, a whole tick of each model, and a
// late camera pose.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "estimator/baselines/motion.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/filter.hpp"

namespace odomd::estimator {
namespace {

constexpr std::int64_t period_ns = 5'000'000;

struct Step {
  double steering, accel_x;
  double yaw_rate, speed;
};

/// A slalom at 1.5 m/s: varying inputs defeat branch prediction and constant folding.
std::array<Step, 1024> slalom() {
  std::array<Step, 1024> steps{};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double t = 0.005 * static_cast<double>(i);
    const double delta = 0.3 * std::sin(2.0 * t);
    const double speed = 1.5 + 0.3 * std::sin(0.7 * t);
    steps[i] = {delta, 0.21 * std::cos(0.7 * t), speed * std::tan(delta) / 0.26, speed};
  }
  return steps;
}

void paper_predict_and_correct(benchmark::State& state) {
  const auto steps = slalom();
  const FilterSettings settings;
  estimator::Motion motion;
  std::size_t i = 0;
  for (auto _ : state) {
    const Step& step = steps[i++ % steps.size()];
    step_paper_ekf(settings, {step.steering, step.accel_x}, {step.yaw_rate, step.speed}, motion);
    benchmark::DoNotOptimize(motion.velocity);
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
    add(filter, Measurement{Source::steering, now, s.steering, 0.02});
    add(filter, Measurement{Source::accel_x, now, s.accel_x, 0.3});
    add(filter, Measurement{Source::yaw_rate, now, s.yaw_rate, 0.03});
    add(filter, Measurement{Source::wheel_rear_left, now, s.speed, 0.05});
    add(filter, Measurement{Source::wheel_rear_right, now, s.speed, 0.05});
    Estimate e = step(filter, now);
    benchmark::DoNotOptimize(e);
  }
}
BENCHMARK_CAPTURE(whole_tick, paper, Model::paper);

/// A camera pose that is eight ticks late, and the tick that processes it.
void camera_pose(benchmark::State& state) {
  constexpr std::int64_t latency = 8 * period_ns - 1;
  Filter filter = make_filter(Model::paper, {});
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
BENCHMARK(camera_pose);

/// The full filter with the traffic of `odom sim` in a slalom: inertial sensors every tick, about 4
/// ms old; alternately the front wheels with the steering, and the rear wheels, which are 10 ms
/// old.
class FullTraffic {
 public:
  FullTraffic() { set_initial_pose(filter_, {}); }

  /// Sends the samples between the last tick and the next.
  void send() {
    now_ += period_ns;
    const std::int64_t taken = now_ - 4'200'000;
    const Motion m = motion(taken);
    say(Source::yaw_rate, taken, m.yaw_rate, 0.005);
    say(Source::accel_x, taken, 0.0, 0.15);
    say(Source::accel_y, taken, speed * m.yaw_rate, 0.15);
    const std::int64_t turned = now_ - 9'600'000;
    if (now_ % (2 * period_ns) == 0) {
      say(Source::wheel_front_left, turned, speed / std::cos(m.steering), 0.0065);
      say(Source::wheel_front_right, turned, speed / std::cos(m.steering), 0.0065);
      say(Source::steering, now_ - 4'100'000, m.steering, 0.001);
    } else {
      say(Source::wheel_rear_left, turned, speed, 0.0065);
      say(Source::wheel_rear_right, turned, speed, 0.0065);
    }
  }

  /// Sends a wheel's sample so late [ns] that the filter repeats everything after it.
  void send_late(std::int64_t late_ns) { say(Source::motor, now_ - late_ns, speed, 0.05); }

  /// Sends a camera pose equal to the estimate of `late_ns` ago.
  void send_camera(std::int64_t late_ns) {
    const Pose2 pose = moved(last_.map, {last_.v_x, last_.v_y, last_.yaw_rate},
                             -1e-9 * static_cast<double>(late_ns - period_ns));
    keep_going(
        add(filter_, CameraPose{now_ - late_ns, now_, pose.x, pose.y, pose.yaw, 0.05, 0.05, 0.05}));
  }

  Estimate step() {
    last_ = estimator::step(filter_, now_);
    return last_;
  }

  /// Whether all samples so far were accepted.
  [[nodiscard]] bool honest() const { return honest_; }

 private:
  static constexpr double speed = 1.5;
  struct Motion {
    double steering;
    double yaw_rate;
  };
  static Motion motion(std::int64_t time) {
    const double delta = 0.1 * std::sin(2e-9 * static_cast<double>(time));
    return {delta, speed * std::tan(delta) / 0.26};
  }
  void say(Source source, std::int64_t time, double value, double sigma) {
    keep_going(add(filter_, Measurement{source, time, value, sigma, now_}));
  }
  void keep_going(std::optional<Verdict> verdict) { honest_ = honest_ && !verdict; }

  Filter filter_ = make_filter(Model::full, {});
  std::int64_t now_ = 1'000'000'000;
  Estimate last_;
  bool honest_ = true;
};

/// A tick of the full filter, with a sample or pose that is `late_ms` late (0: without).
template <void (FullTraffic::*late)(std::int64_t)>
void full_tick(benchmark::State& state) {
  const std::int64_t late_ns = state.range(0) * 1'000'000;
  FullTraffic traffic;
  for (int i = 0; i < 400; ++i) {
    traffic.send();
    traffic.step();
  }
  for (auto _ : state) {
    traffic.send();
    if (late_ns != 0) {
      (traffic.*late)(late_ns);
    }
    Estimate e = traffic.step();
    benchmark::DoNotOptimize(e);
  }
  if (!traffic.honest()) {
    state.SkipWithError("a sample was refused");
  }
}
BENCHMARK_TEMPLATE(full_tick, &FullTraffic::send_camera)->Name("full_tick")->Arg(0);
BENCHMARK_TEMPLATE(full_tick, &FullTraffic::send_camera)->Name("full_tick_late_camera")->Arg(40);
BENCHMARK_TEMPLATE(full_tick, &FullTraffic::send_late)->Name("full_tick_late_wheel")->Arg(249);

}  // namespace
}  // namespace odomd::estimator
