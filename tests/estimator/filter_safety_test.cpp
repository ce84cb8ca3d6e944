// Every model: resumes from a predecessor, takes no heap, and survives any input.
#include <limits>
#include <numeric>
#include <random>

#include "every_model.hpp"
#include "tests/allocation_count.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::filter_test {
namespace {

using testing::millisecond;

class Safety : public EveryModel {};
INSTANTIATE_TEST_SUITE_P(, Safety, every_model, name_of_model);

TEST_P(Safety, ResumesWhereThePredecessorWouldBeInBothFrames) {
  Drive predecessor = start(GetParam());
  const Samples steady{.speed = 1.0, .steering = 0.1, .yaw_rate = 0.38, .accel_x = 0.0};
  Estimate last = predecessor.ticks(400, steady);
  last.map.x += 10.0;  // as after a correction by a camera

  Drive drive = start(GetParam(), {}, std::nullopt);
  ASSERT_TRUE(resume(drive.filter, last, 0.2));
  const Estimate e = drive.tick({});
  EXPECT_TRUE(e.initialised);
  EXPECT_EQ(e.reset_count, last.reset_count + 1);
  const Estimate truth = predecessor.ticks(41, steady);
  EXPECT_NEAR(e.map.x, truth.map.x + 10.0, 0.01);
  EXPECT_NEAR(e.map.y, truth.map.y, 0.01);
  EXPECT_NEAR(e.odom.x, truth.odom.x, 0.01);
  EXPECT_NEAR(e.v_x, truth.v_x, 0.1);
  EXPECT_GT(e.covariance[0], last.covariance[0]);
  EXPECT_GT(e.covariance[5], last.covariance[5]);
  EXPECT_TRUE(is_positive_definite(e.covariance));
}

TEST_P(Safety, DoesNotResumeFromUnusableEstimates) {
  const Estimate good = slalom_for(GetParam(), 400).last;
  Drive drive = start(GetParam(), {}, std::nullopt);
  using Change = void (*)(Estimate&);
  for (const auto& [what, change] : {
           std::pair<const char*, Change>{"no pose", [](Estimate& e) { e.initialised = false; }},
           {"a fault", [](Estimate& e) { e.model_fault = true; }},
           {"NaN", [](Estimate& e) { e.map.x = std::nan(""); }},
           {"no covariance", [](Estimate& e) { e.covariance = {}; }},
           {"a huge covariance", [](Estimate& e) { e.covariance[0] = 1e300; }},
           // Finite, but impossible for a car.
           {"v_x 1e4", [](Estimate& e) { e.v_x = 1e4; }},
           {"v_x -1e300", [](Estimate& e) { e.v_x = -1e300; }},
           {"yaw_rate 1e4", [](Estimate& e) { e.yaw_rate = 1e4; }},
           {"yaw_rate -1e300", [](Estimate& e) { e.yaw_rate = -1e300; }},
       }) {
    Estimate bad = good;
    change(bad);
    EXPECT_FALSE(resume(drive.filter, bad, 0.1)) << what;
  }
  EXPECT_FALSE(resume(drive.filter, good, -0.1));
  EXPECT_FALSE(resume(drive.filter, good, std::nan("")));
  EXPECT_FALSE(drive.tick({.speed = 1.0}).initialised);
  Estimate without_velocity = good;
  without_velocity.velocity_covariance = {};
  EXPECT_TRUE(resume(drive.filter, without_velocity, 0.1));
  EXPECT_TRUE(is_positive_definite(drive.tick({.speed = 1.0}).covariance));
}

TEST_P(Safety, DoesNotAllocate) {
  Drive drive = slalom_for(GetParam(), 300);
  const std::size_t before = allocation_count();
  for (int i = 300; i < 900; ++i) {
    if (i % 7 == 0) drive.see(drive.last.map, 0.1, 0.1, testing::period_ns);
    drive.tick(slalom(i));
  }
  EXPECT_EQ(allocation_count(), before);
}

TEST_P(Safety, CovariancesStayPositiveDefiniteInTurnsAtRestAndThroughAWildDrive) {
  for (const double turn : {0.0, 0.5, -0.5}) {
    Drive drive = start(GetParam());
    for (const double speed : {0.0, 3.0, -3.0}) {
      drive.ticks(300, {.speed = speed, .steering = turn, .yaw_rate = 10.0 * turn});
      EXPECT_TRUE(is_positive_definite(drive.last.covariance)) << speed << ' ' << turn;
      EXPECT_TRUE(is_positive_definite(drive.last.velocity_covariance)) << speed << ' ' << turn;
    }
  }
  Drive drive = start(GetParam());
  for (int i = 0; i < 20'000; ++i) {
    const double t = 0.005 * i;
    const Samples wild{.speed = 5.0 + 5.0 * std::sin(t),
                       .steering = 0.6 * std::sin(7.0 * t),
                       .yaw_rate = 10.0 * std::sin(13.0 * t),
                       .accel_x = 20.0 * std::cos(3.0 * t)};
    const Estimate e = drive.tick(wild);
    ASSERT_TRUE(is_positive_definite(e.covariance)) << t;
    ASSERT_TRUE(is_positive_definite(e.velocity_covariance)) << t;
    ASSERT_TRUE(std::isfinite(e.map.x) && std::isfinite(e.v_y) && std::isfinite(e.yaw_accel));
  }
}

/// Numbers that a broken sensor or a hostile sender might send.
class Junk {
 public:
  double number() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const std::array<double, 12> unusual{0.0,       -0.0,         1e-308, 1e308, -1e308, infinity,
                                         -infinity, std::nan(""), 1e-3,   150.0, -1.4,   1e7};
    return pick(3) == 0 ? unusual[pick(unusual.size())]
                        : std::normal_distribution<>{0.0, 2.0}(random_);
  }
  std::int64_t time(std::int64_t now) {
    if (pick(10) == 0) return static_cast<std::int64_t>(random_());
    return now + std::uniform_int_distribution<std::int64_t>{-300 * millisecond,
                                                             20 * millisecond}(random_);
  }
  std::size_t pick(std::size_t count) { return random_() % count; }

 private:
  std::mt19937_64 random_{2026};
};

TEST_P(Safety, NoInputLeavesAnEstimateThatIsNotFiniteOrASampleWithoutVerdict) {
  Junk junk;
  FilterSettings settings;
  settings.initialise_from_camera = true;
  Drive drive = start(GetParam(), settings, std::nullopt);
  std::array<int, verdict_count> verdicts{};
  int offered = 0;
  const auto offer = [&](const auto& sample) {
    ++offered;
    if (const auto verdict = add(drive.filter, sample))
      ++verdicts.at(static_cast<std::size_t>(*verdict));
  };
  const auto tick = [&] {
    const Estimate e = drive.tick();
    for (const Judgement& judgement : judgements(drive.filter))
      verdicts.at(static_cast<std::size_t>(judgement.verdict)) += static_cast<int>(judgement.count);
    return e;
  };
  // A step of the full filter replays a window full of invalid samples.
  const int steps = GetParam() == Model::full ? 5'000 : 20'000;
  for (int i = 0; i < steps; ++i) {
    for (std::size_t n = junk.pick(8); n > 0; --n) {
      offer(Measurement{static_cast<Source>(junk.pick(source_count + 2)), junk.time(drive.now_ns),
                        junk.number(), std::abs(junk.number()),
                        junk.pick(2) == 0 ? 0 : junk.time(drive.now_ns)});
    }
    if (junk.pick(5) == 0) {
      offer(CameraPose{junk.time(drive.now_ns), junk.time(drive.now_ns), junk.number(),
                       junk.number(), junk.number(), std::abs(junk.number()),
                       std::abs(junk.number()), std::abs(junk.number())});
    }
    // Sometimes a gap of seconds.
    drive.now_ns += static_cast<std::int64_t>(junk.pick(i % 1000 == 999 ? 1000 : 3)) * period_ns;
    const Estimate e = tick();
    ASSERT_TRUE(is_finite(e.map) && is_finite(e.odom) && is_finite(e.last_jump)) << i;
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x, e.v_y, e.yaw_rate})) << i;
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x_dot, e.v_y_dot, e.yaw_accel})) << i;
    ASSERT_TRUE(is_positive_definite(e.covariance)) << i;
    ASSERT_TRUE(is_positive_definite(e.velocity_covariance)) << i;
    ASSERT_FALSE(std::isnan(e.camera_test_ratio)) << i;
  }
  for (int i = 0; i < 100; ++i) tick();
  EXPECT_EQ(std::accumulate(verdicts.begin(), verdicts.end(), 0), offered);
  for (const Verdict verdict : {Verdict::fused, Verdict::gated, Verdict::too_old, Verdict::future,
                                Verdict::non_finite, Verdict::source_off}) {
    EXPECT_GT(verdicts[static_cast<std::size_t>(verdict)], 0)
        << verdict_names[static_cast<std::size_t>(verdict)];
  }
}

}  // namespace
}  // namespace odomd::estimator::filter_test
