// Maximum work of a step of the full filter. Counting fakes replace the work on the state: this
// program defines advance() etc., so the library's are not linked.
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace {

int advances = 0;
int takes = 0;

}  // namespace

namespace odomd::estimator::full {

void advance(const Context& /*context*/, State& state, std::int64_t time_ns) noexcept {
  ++advances;
  state.time_ns = time_ns;
}

Input input_of(const State& /*state*/) noexcept {
  return {};
}

void apply_integrity(const Context& /*context*/, State& /*state*/) noexcept {}

Judgement take(const Context& /*context*/, State& state, const Sample& sample) noexcept {
  ++takes;
  EXPECT_EQ(sample.time_ns, state.time_ns);
  return {.source = sample.source, .verdict = Verdict::fused};
}

}  // namespace odomd::estimator::full

namespace odomd::estimator::work_test {
namespace {

constexpr std::int64_t millisecond = 1'000'000;
constexpr std::int64_t start_ns = 1'000'000'000;
constexpr auto capacity = static_cast<int>(full::SampleWindow::capacity);

/// Ticks of a filter whose window is kept as full as possible.
class Flood {
 public:
  explicit Flood(const FilterSettings& settings, int samples_per_tick)
      : filter_(settings),
        period_ns_(static_cast<std::int64_t>(settings.period_s * 1e9)),
        samples_per_tick_(samples_per_tick) {
    filter_.set_initial_pose({});
  }

  void tick() {
    now_ns_ += period_ns_;
    for (int i = 0; i < samples_per_tick_; ++i)
      (void)filter_.add(Measurement{Source::yaw_rate, now_ns_ - std::int64_t{1000} * i, 0.0, 0.01});
    step();
  }
  std::optional<Verdict> add_late(std::int64_t late_ns) {
    return filter_.add(Measurement{Source::motor, now_ns_ - late_ns, 0.0, 0.01});
  }
  void step() {
    advances = takes = 0;
    (void)filter_.step(now_ns_);
  }
  void sleep(std::int64_t ns) { now_ns_ += ns; }

 private:
  FullFilter filter_;
  std::int64_t period_ns_;
  int samples_per_tick_;
  std::int64_t now_ns_ = start_ns;
};

TEST(FullFilterWork, ATickWithoutLateSamplesDoesOnlyWhatIsNew) {
  Flood flood({}, 8);
  for (int i = 0; i < 200; ++i) flood.tick();
  EXPECT_EQ(takes, 8);
  EXPECT_EQ(advances, 9);
}

TEST(FullFilterWork, TheLongestRewindIsTheWindowOfTicksAndAWindowOfSamples) {
  for (const double period_s : {0.001, 0.002, 0.005, 0.01}) {
    FilterSettings settings;
    settings.period_s = period_s;
    const int window_ticks = static_cast<int>(settings.window_s / period_s) + 1;
    // Just enough samples to fill the window of samples when the window of time is full.
    Flood flood(settings, capacity / window_ticks);
    int most_takes = 0;
    for (int i = 0; i < 1000; ++i) {
      flood.sleep(static_cast<std::int64_t>(period_s * 1e9));
      if (i > window_ticks) {
        EXPECT_EQ(flood.add_late(static_cast<std::int64_t>(settings.window_s * 1e9) - 10'000 - i),
                  std::nullopt);
      }
      flood.sleep(-static_cast<std::int64_t>(period_s * 1e9));
      flood.tick();
      most_takes = std::max(most_takes, takes);
      ASSERT_LE(takes, capacity);
      // Kept states may lie a few ticks apart.
      ASSERT_LE(advances - takes, window_ticks * 3 / 2 + 8);
    }
    EXPECT_GT(most_takes, capacity / 2) << period_s;  // the replay was long
  }
}

TEST(FullFilterWork, AWindowOfTicksThatComeALittleEarlyOrLateIsKeptAsAWhole) {
  FilterSettings settings;
  settings.period_s = 0.002;  // every third state is kept
  Flood flood(settings, 1);
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t early_ns = std::int64_t{300'000} * (i % 3);
    flood.sleep(-early_ns);
    flood.tick();
    flood.sleep(early_ns);
    if (i > 130) {
      ASSERT_EQ(flood.add_late(240 * millisecond - i), std::nullopt) << i;
    }
    ASSERT_LE(advances - takes, 125 * 3 / 2 + 4) << i;
  }
}

TEST(FullFilterWork, WakingUpAfterAnyTimeDoesNoMoreThanASecondAndAWindow) {
  Flood flood({}, 4);
  for (const std::int64_t ms : {100, 900, 1'200, 1'300, 10'000, 1'000'000}) {
    for (int i = 0; i < 100; ++i) flood.tick();
    flood.sleep(ms * millisecond);
    flood.tick();
    EXPECT_LE(advances - takes, 200 + 75) << ms;
    EXPECT_GE(advances - takes, std::min<std::int64_t>(200, ms / 5)) << ms;
  }
}

}  // namespace
}  // namespace odomd::estimator::work_test
