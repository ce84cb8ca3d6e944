// Corrupt samples that pass the checks: with a checksum of 8 bits, one random frame in 256 passes.
// A single corrupt frame must not move the pose, whatever it contains and whatever follows. Sensors
// that are stuck at the end of their range for seconds: their effect must end with the failure. And
// a state that has become invalid: it is counted, never published, and restarted from the last
// pose.
#include <functional>
#include <limits>
#include <random>

#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::corrupt_samples_test {
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
Estimate drive(const Motion& motion, Then then, const Frame* frame, std::mt19937& random) {
  static constexpr std::array<double, source_count> sigmas{0.0005, 0.005, 0.005, 0.001, 0.001,
                                                           0.001,  0.001, 0.001, 0.001, 0.0005};
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Drive car = start(Model::full);
  const auto send = [&car](Source source, double value, std::int64_t age_ns) {
    car.send(source, value, sigmas[index_of(source)], age_ns);
  };
  for (int tick = 1; tick <= 400; ++tick) {
    if (tick <= 100 || then == Then::more) {
      send(Source::yaw_rate, motion.turn, millisecond);
      send(Source::accel_x, 0.0, millisecond);
      send(Source::accel_y, motion.speed * motion.turn, millisecond);
      if (tick % 2 == 0) {
        send(Source::steering, motion.speed == 0.0 ? 0.0 : 0.26 * motion.turn / motion.speed,
             millisecond);
        const double side = 0.08 * motion.turn;
        send(Source::wheel_rear_left, motion.speed - side, 2 * millisecond);
        send(Source::wheel_rear_right, motion.speed + side, 2 * millisecond);
        send(Source::wheel_front_left, motion.speed - side, 3 * millisecond);
        send(Source::wheel_front_right, motion.speed + side, 3 * millisecond);
      }
    }
    if (tick == 100 && frame != nullptr)
      for (const auto& [source, reach] : frame->signals)
        if (reach > 0.0) send(source, reach * std::pow(any(random), 3), 500'000);
    car.tick();
  }
  return car.last;
}

constexpr std::array motions{Motion{}, Motion{2.0, 0.0}, Motion{2.0, 1.0}};

/// Calls `check` with the last estimates of every drive, with a corrupt frame and without.
void try_all(Then then,
             const std::function<void(const Estimate& corrupt, const Estimate& clean)>& check) {
  for (const Motion motion : motions) {
    std::mt19937 random(1);
    const Estimate clean = drive(motion, then, nullptr, random);
    for (const Frame& frame : frames) {
      for (const unsigned seed : {3U, 5U, 7U}) {
        random.seed(seed);
        const Estimate e = drive(motion, then, &frame, random);
        check(e, clean);
        if (motion.speed == 0.0) {  // a standstill goes on
          EXPECT_LT(std::hypot(e.map.x, e.map.y), 0.01);
          EXPECT_LT(std::sqrt(e.covariance[0]), 0.06);
          EXPECT_EQ(e.mode, Mode::standstill);
        }
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

TEST(CorruptSamples, OneAmongTheCarsOwnHardlyMovesThePose) {
  try_all(Then::more, [](const Estimate& corrupt, const Estimate& clean) {
    EXPECT_LT(apart(corrupt, clean), 0.3);
    EXPECT_NEAR(corrupt.map.yaw, clean.map.yaw, 0.1);
  });
}

// Rails
// --------------------------------------------------------------------------------------------

struct Rail {
  double gyro;   ///< 0: healthy
  double accel;  ///< likewise, both axes
};

/// 12 s on a circle; from 4 s to 7 s sensors are stuck at the ends of their ranges.
std::vector<Arrival> drive_with(const Rail& rail) {
  std::vector<Arrival> arrivals = drive_on_a_circle(12'000 * millisecond);
  for (Arrival& arrival : arrivals) {
    if (!arrival.signal || arrival.signal->time_ns < start_ns + 4'000 * millisecond ||
        arrival.signal->time_ns > start_ns + 7'000 * millisecond) {
      continue;
    }
    const Source source = arrival.signal->source;
    const double reads = source == Source::yaw_rate ? rail.gyro : rail.accel;
    if (is_inertial(source) && reads != 0.0) arrival.signal->value = reads;
  }
  return arrivals;
}

class RailedSensors : public ::testing::TestWithParam<Rail> {};

TEST_P(RailedSensors, LeaveNothingBehind) {
  const std::vector<Estimate> estimates = run(drive_with(GetParam()), 2400);
  const Estimate& e = estimates.back();
  EXPECT_EQ(e.recoveries, estimates[1599].recoveries) << "none once it is healthy";
  EXPECT_NEAR(e.v_x, circle.v_x, 0.05);
  EXPECT_NEAR(e.yaw_rate, circle.yaw_rate, 0.05);
  const Pose2 truth = on_circle(e.time_ns);
  EXPECT_NEAR(e.map.x, truth.x, 0.03);
  EXPECT_NEAR(e.map.y, truth.y, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Imu, RailedSensors,
                         ::testing::Values(Rail{0.0, 157.0}, Rail{0.0, -157.0}, Rail{0.0, 50.0},
                                           Rail{34.9, 0.0}, Rail{34.9, 157.0}, Rail{-34.9, -157.0},
                                           Rail{8.7, 19.6}));

TEST(Recovery, KeepsThePoseThatWasGivenAndFiniteNumbers) {
  // A mass that no configuration allows makes every step of the model NaN.
  FilterSettings settings;
  settings.vehicle.mass = std::numeric_limits<double>::quiet_NaN();
  FullFilter filter(settings);
  const Pose2 given{12.0, -3.0, 0.7};
  filter.set_initial_pose(given);
  auto arrivals = drive_on_a_circle(500 * millisecond);
  std::erase_if(arrivals, [](const auto& arrival) { return arrival.camera.has_value(); });
  const std::vector<Estimate> estimates = run(filter, arrivals, 101);
  for (const Estimate& e : estimates) {
    // The pose stays there, although the car drives at 2 m/s.
    EXPECT_THAT(e.map, PoseNear(given, 0.1)) << e.time_ns;
    EXPECT_THAT(e.odom, PoseNear(given, 0.1)) << e.time_ns;
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x, e.v_y, e.yaw_rate})) << e.time_ns;
    ASSERT_TRUE(is_finite(e.covariance)) << e.time_ns;
  }
  EXPECT_GT(std::ranges::count_if(estimates, &Estimate::initialised), 90);
  EXPECT_GT(estimates.back().recoveries, 90U);
  EXPECT_GT(estimates.back().covariance[0], 10.0 * estimates[5].covariance[0]);
}

}  // namespace
}  // namespace odomd::estimator::testing::corrupt_samples_test
