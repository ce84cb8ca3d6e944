// Corrupt samples that pass the checks: with a checksum of 8 bits, one random frame in 256 passes.
// A single corrupt frame must not move the pose, whatever it contains and whatever follows.
#include <functional>
#include <random>

#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing {
namespace {

/// A message, and the ranges of its signals.
struct Frame {
  std::array<std::pair<Source, double>, 3> signals{};  ///< range 0: unused
};
using Signal = std::pair<Source, double>;
constexpr std::array<Frame, 4> frames{
    Frame{{Signal{Source::yaw_rate, 26.0}, {Source::accel_x, 163.0}, {Source::accel_y, 163.0}}},
    Frame{{Signal{Source::wheel_front_left, 83.0}, {Source::wheel_front_right, 83.0}}},
    Frame{{Signal{Source::wheel_rear_left, 83.0}, {Source::wheel_rear_right, 83.0}}},
    Frame{{Signal{Source::steering, 0.8}}},
};

/// Samples after the corrupt frame: none, or the car's own.
enum class Then : std::uint8_t { silence, more };

struct Motion {
  double speed = 0.0;
  double turn = 0.0;
};

/// Half a second of a car's own samples, one corrupt frame, and 1.5 s afterwards.
class Drive {
 public:
  Drive(Motion motion, Then then) : motion_(motion), then_(then) {
    filter_.set_initial_pose(Pose2{});
  }

  Estimate with(const Frame* frame, std::mt19937& random) {
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    Estimate last;
    for (int tick = 1; tick <= 400; ++tick) {
      now_ns_ = start_ns + tick * period_ns;
      if (tick <= 100 || then_ == Then::more) own(tick);
      if (tick == 100 && frame != nullptr)
        for (const auto& [source, reach] : frame->signals)
          if (reach > 0.0) give(source, reach * std::pow(any(random), 3), 500'000);
      last = filter_.step(now_ns_);
    }
    return last;
  }

 private:
  void give(Source source, double value, std::int64_t age_ns) {
    constexpr std::array<double, source_count> sigma{0.0005, 0.005, 0.005, 0.001, 0.001,
                                                     0.001,  0.001, 0.001, 0.001, 0.0005};
    (void)filter_.add({source, now_ns_ - age_ns, value, sigma[index_of(source)], now_ns_});
  }
  void own(int tick) {
    give(Source::yaw_rate, motion_.turn, millisecond);
    give(Source::accel_x, 0.0, millisecond);
    give(Source::accel_y, motion_.speed * motion_.turn, millisecond);
    if (tick % 2 == 0) {
      give(Source::steering, motion_.speed == 0.0 ? 0.0 : 0.26 * motion_.turn / motion_.speed,
           millisecond);
      const double side = 0.08 * motion_.turn;
      give(Source::wheel_rear_left, motion_.speed - side, 2 * millisecond);
      give(Source::wheel_rear_right, motion_.speed + side, 2 * millisecond);
      give(Source::wheel_front_left, motion_.speed - side, 3 * millisecond);
      give(Source::wheel_front_right, motion_.speed + side, 3 * millisecond);
    }
  }

  FullFilter filter_{FilterSettings{}};
  Motion motion_;
  Then then_;
  std::int64_t now_ns_ = 0;
};

constexpr std::array motions{Motion{}, Motion{2.0, 0.0}, Motion{2.0, 1.0}};

/// Calls `check` with the last estimates of every drive, with a corrupt frame and without.
void try_all(Then then,
             const std::function<void(const Estimate& corrupt, const Estimate& clean)>& check) {
  for (const Motion motion : motions) {
    std::mt19937 random(1);
    const Estimate clean = Drive(motion, then).with(nullptr, random);
    for (const Frame& frame : frames) {
      for (const unsigned seed : {3U, 5U, 7U}) {
        random.seed(seed);
        check(Drive(motion, then).with(&frame, random), clean);
        if (::testing::Test::HasFailure()) {
          FAIL() << "at " << motion.speed << " m/s, " << motion.turn << " rad/s; "
                 << source_names[index_of(frame.signals[0].first)] << ", seed " << seed;
        }
      }
    }
  }
}

double apart(const Estimate& a, const Estimate& b) {
  return std::hypot(a.map.x - b.map.x, a.map.y - b.map.y);
}

TEST(CorruptSamples, OneBeforeAGapLeavesThePoseWithinItsThreeSigmas) {
  try_all(Then::silence, [](const Estimate& corrupt, const Estimate& clean) {
    EXPECT_LT(apart(corrupt, clean),
              3.0 * std::sqrt(std::max(corrupt.covariance[0], corrupt.covariance[3])));
  });
}

TEST(CorruptSamples, OneDoesNotEndAStandstill) {
  std::mt19937 random;
  for (const Then then : {Then::silence, Then::more}) {
    for (const Frame& frame : frames) {
      for (const unsigned seed : {3U, 5U, 7U}) {
        random.seed(seed);
        const Estimate e = Drive({}, then).with(&frame, random);
        EXPECT_LT(std::hypot(e.map.x, e.map.y), 0.01) << seed;
        EXPECT_LT(std::sqrt(e.covariance[0]), 0.06) << seed;
        EXPECT_EQ(e.mode, Mode::standstill) << seed;
      }
    }
  }
}

TEST(CorruptSamples, OneAmongTheCarsOwnHardlyMovesThePose) {
  try_all(Then::more, [](const Estimate& corrupt, const Estimate& clean) {
    EXPECT_LT(apart(corrupt, clean), 0.3);
    EXPECT_NEAR(corrupt.map.yaw, clean.map.yaw, 0.1);
  });
}

}  // namespace
}  // namespace odomd::estimator::testing
