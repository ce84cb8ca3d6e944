#include "daemon/core/pipeline.hpp"

#include <bit>
#include <memory>

#include "tests/gtest.hpp"

namespace odomd::daemon::pipeline_test {
namespace {

using estimator::Source;
using estimator::Verdict;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start = 1'000'000 * ms;
constexpr std::size_t gyro = 0;
constexpr auto wheel = static_cast<std::size_t>(Source::wheel_rear);
constexpr auto camera = static_cast<std::size_t>(Source::camera);

constexpr std::string_view bus = R"(VERSION ""
BO_ 256 IMU: 4 Car
 SG_ YawRate : 0|16@1- (0.001,0) [0|0] "rad/s" X
 SG_ Counter : 16|4@1+ (1,0) [0|15] "" X

BO_ 257 WHEEL: 2 Car
 SG_ Speed : 0|16@1- (0.001,0) [0|0] "m/s" X
)";

Config two_signals(estimator::Model model = estimator::Model::kinematic) {
  Config config;
  config.model = model;
  config.can.bindings = {
      {.channel = gyro,
       .role = "yaw_rate",
       .message = "IMU",
       .signals = {"YawRate"},
       .unit = can::Unit::rad_per_s},
      {.channel = wheel,
       .role = "wheel_rear",
       .message = "WHEEL",
       .signals = {"Speed"},
       .unit = can::Unit::m_per_s},
  };
  config.can.protections = {
      {.message = "IMU", .profile = can::E2eProfile::counter, .counter_signal = "Counter"}};
  config.can.signals[gyro] = {.configured = true, .sigma = 0.03, .timeout_ns = 30 * ms};
  config.can.signals[wheel] = {.configured = true, .sigma = 0.02, .timeout_ns = 30 * ms};
  config.initial_pose = estimator::Pose2{};
  return config;
}

/// A car's pipeline. Times are in ms after the start; frames arrive at their time.
struct Car {
  explicit Car(const Config& config = two_signals(), bool camera_expected = false)
      : pipeline(std::make_unique<Pipeline>(
            config, std::vector<can::Database>{can::parse_dbc(bus, "test.dbc")},
            std::vector<std::string>{"can0", "can1"}, camera_expected)) {}

  void wheel_reads(std::int64_t at_ms, std::int16_t value) const {
    take(257, start + at_ms * ms, value, start + at_ms * ms);
  }
  void gyro_reads(std::int64_t at_ms, std::int16_t value, std::int64_t counter) const {
    take(256, start + at_ms * ms, value, start + at_ms * ms, counter);
  }
  void take(std::uint32_t id, std::int64_t time_ns, std::int16_t value, std::int64_t now_ns,
            std::int64_t counter = 0) const {
    can::Frame frame{.time_ns = time_ns, .id = id, .length = 4};
    const auto raw = std::bit_cast<std::uint16_t>(value);
    frame.data[0] = static_cast<std::uint8_t>(raw & 0xFFU);
    frame.data[1] = static_cast<std::uint8_t>(raw >> 8U);
    frame.data[2] = static_cast<std::uint8_t>(counter % 16);
    pipeline->take(frame, now_ns);
  }
  [[nodiscard]] const TickRecord& tick(std::int64_t at_ms) const {
    return pipeline->tick(static_cast<std::uint64_t>(at_ms / 5), start + at_ms * ms);
  }
  /// Takes a camera pose and ticks; whether the camera counts as rejected.
  [[nodiscard]] bool rejects(const estimator::CameraPose& pose, std::int64_t at_ms) const {
    pipeline->take(pose);
    return (tick(at_ms).pose.conditions & ODOM_COND_CAMERA_REJECTED) != 0;
  }
  [[nodiscard]] std::uint64_t count(std::size_t source, Verdict verdict) const {
    return pipeline->statistics().sources[source].verdicts[static_cast<std::size_t>(verdict)].get();
  }
  [[nodiscard]] estimator::SourceFlag flag(std::size_t source) const {
    return static_cast<estimator::SourceFlag>(pipeline->statistics().sources[source].flag.get());
  }
  std::unique_ptr<Pipeline> pipeline;
};

estimator::CameraPose seen(double x, std::int64_t capture_ms, std::int64_t arrival_ms,
                           double sigma = 0.01) {
  return {.capture_ns = start + capture_ms * ms,
          .arrival_ns = start + arrival_ms * ms,
          .x = x,
          .sigma_x = sigma,
          .sigma_y = sigma,
          .sigma_yaw = sigma};
}

TEST(Pipeline, DrivesStraightAheadAtTheWheelsSpeed) {
  const Car car;
  const TickRecord* record = nullptr;
  for (std::int64_t t = 0; t <= 1000; t += 5) {
    car.wheel_reads(t, 1500);
    record = &car.tick(t);
  }
  EXPECT_TRUE(record->initialised);
  EXPECT_EQ(record->pose.tick, 200U);
  EXPECT_EQ(record->pose.time_ns, start + 1000 * ms);
  EXPECT_NEAR(record->pose.x, 1.5, 0.01);
  EXPECT_NEAR(record->pose.vx, 1.5, 1e-9);
  EXPECT_EQ(record->details.frames[0], 201U);
  EXPECT_EQ(car.count(wheel, Verdict::fused), 201U);
}

TEST(Pipeline, IsNotInitialisedBeforeTheFirstWheelSample) {
  const Car car;
  EXPECT_FALSE(car.tick(0).initialised);
  EXPECT_EQ(car.tick(5).pose.mode, ODOM_INITIALISING);
}

TEST(Pipeline, WaitsForTheCameraWhereItIsToInitialise) {
  Config waiting = two_signals();
  waiting.initial_pose.reset();
  const Car car(waiting, true);
  car.wheel_reads(0, 0);
  EXPECT_FALSE(car.tick(0).initialised);

  estimator::CameraPose pose = seen(2.0, 0, 5);
  pose.yaw = 0.5;
  car.pipeline->take(pose);
  const TickRecord& record = car.tick(5);
  EXPECT_TRUE(record.initialised);
  EXPECT_NEAR(record.pose.x, 2.0, 1e-9);
  EXPECT_NEAR(record.pose.yaw, 0.5, 1e-9);
  EXPECT_EQ(record.details.camera_messages, 1U);
  EXPECT_EQ(car.count(camera, Verdict::fused), 1U);
}

TEST(Pipeline, CountsValuesThatDoNotCount) {
  Config odd = two_signals();
  odd.can.bindings[0].valid_when = {{"YawRate", 1.0, can::Comparison::below}};
  const Car car(odd);
  car.wheel_reads(0, 32767);  // the first value, at an end of the range
  car.gyro_reads(0, 1000, 1);
  car.wheel_reads(1, 500);
  EXPECT_EQ(car.tick(5).pose.health, 1U << wheel);
  EXPECT_EQ(car.count(wheel, Verdict::not_valid), 1U);
  EXPECT_EQ(car.count(wheel, Verdict::fused), 1U);
  EXPECT_EQ(car.count(gyro, Verdict::not_valid), 1U);
  EXPECT_EQ(car.count(gyro, Verdict::fused), 0U);
}

TEST(Pipeline, AFrameThatFailsItsProtectionUpdatesNothing) {
  const Car car;
  car.wheel_reads(0, 1000);
  car.gyro_reads(0, 100, 1);
  car.gyro_reads(1, 200, 1);  // the counter does not change
  const TickRecord& record = car.tick(5);
  EXPECT_EQ(car.count(gyro, Verdict::failed_protection), 1U);
  EXPECT_TRUE(record.pose.conditions & ODOM_COND_PROTECTION);
  EXPECT_FALSE(record.pose.health & (1U << gyro));
  EXPECT_EQ(record.details.source_age_ns[gyro], 5 * ms);  // age of the good frame

  car.gyro_reads(6, 300, 2);
  EXPECT_FALSE(car.tick(10).pose.conditions & ODOM_COND_PROTECTION);
}

TEST(Pipeline, CountsASampleThatAFloodPushedOut) {
  const Car car(two_signals(estimator::Model::full));
  (void)car.tick(0);
  constexpr std::int64_t flood = 3000;
  for (std::int64_t i = 1; i <= flood; ++i) car.take(257, start + i, 1500, start + 5 * ms);
  (void)car.tick(5);
  EXPECT_EQ(car.count(wheel, Verdict::too_old), flood - 1024);
  EXPECT_EQ(car.count(wheel, Verdict::fused) + car.count(wheel, Verdict::gated), 1024U);
}

TEST(Pipeline, SaysWhichSourceIsOverdueAndDegrades) {
  const Car car;
  car.wheel_reads(0, 1000);
  car.gyro_reads(0, 0, 1);
  const TickRecord& fresh = car.tick(0);
  EXPECT_EQ(fresh.pose.conditions, 0U);
  EXPECT_EQ(fresh.pose.health, (1U << gyro) | (1U << wheel));

  car.wheel_reads(31, 1000);
  const TickRecord& late = car.tick(35);
  EXPECT_EQ(late.pose.conditions, static_cast<std::uint32_t>(ODOM_COND_SIGNAL_TIMEOUT));
  EXPECT_EQ(late.pose.health, 1U << wheel);
  EXPECT_EQ(late.pose.mode, ODOM_DEGRADED);
}

TEST(Pipeline, GivesStampsThatStandStillOrRunBackwardsAVerdictNotTrust) {
  const Car car;
  car.wheel_reads(0, 1000);
  car.wheel_reads(0, 9000);
  car.take(257, start - 1 * ms, 9000, start);
  EXPECT_NEAR(car.tick(0).pose.vx, 1.0, 1e-9);
  EXPECT_EQ(car.count(wheel, Verdict::duplicate), 1U);
  EXPECT_EQ(car.count(wheel, Verdict::too_old), 1U);
}

TEST(Pipeline, TimesFramesWithoutAUsableStampByTheirDrain) {
  const Car car;
  car.take(257, 0, 1000, start);
  EXPECT_EQ(car.tick(2).details.source_age_ns[wheel], 2 * ms);
  car.take(257, start + 900 * ms, 1000, start + 5 * ms);
  EXPECT_EQ(car.tick(7).details.source_age_ns[wheel], 2 * ms);
  const auto& stamps = car.pipeline->statistics().stamps;
  EXPECT_EQ(stamps[static_cast<std::size_t>(can::StampVerdict::zero)].get(), 1U);
  EXPECT_EQ(stamps[static_cast<std::size_t>(can::StampVerdict::future)].get(), 1U);
}

TEST(Pipeline, TakesFreshSamplesAfterSkippedTicks) {
  const Car car;
  car.wheel_reads(0, 1000);
  (void)car.tick(0);
  car.wheel_reads(99, 2000);
  (void)car.tick(100);
  EXPECT_EQ(car.count(wheel, Verdict::fused), 2U);
}

TEST(Pipeline, CountsTheFramesOfEachBusButNoErrorFrames) {
  const Car car;
  car.pipeline->take({.time_ns = start, .id = 0x7FF, .bus = 1, .length = 2}, start);
  car.pipeline->take({.time_ns = start, .id = 4, .kind = can::FrameKind::error}, start);
  const TickRecord& record = car.tick(0);
  EXPECT_EQ(record.details.frames[0], 0U);
  EXPECT_EQ(record.details.frames[1], 1U);
  const auto& frames = car.pipeline->statistics().frames;
  EXPECT_EQ(frames[static_cast<std::size_t>(can::FrameVerdict::unmapped)].get(), 1U);
}

TEST(Pipeline, HandsOutTheNoiseThatItsFilterEstimates) {
  for (const auto model : {estimator::Model::full, estimator::Model::kinematic}) {
    const Car car(two_signals(model));
    const auto& sources = car.pipeline->statistics().sources;
    // The car stands for a second, then drives; the gyro alternates between 0 and 10 mrad/s.
    for (std::int64_t k = 0; k <= 400; ++k) {
      car.wheel_reads(k * 5, k < 200 ? 0 : 1500);
      car.gyro_reads(k * 5, static_cast<std::int16_t>(k % 2 * 10), k);
      (void)car.tick(k * 5);
      EXPECT_FALSE(k == 0 && sources[gyro].noise.get().estimated());
    }
    const estimator::SourceNoise noise = sources[gyro].noise.get();
    const bool estimates = model == estimator::Model::full;
    EXPECT_EQ(noise.estimated(), estimates);
    EXPECT_EQ(noise.stated, estimates ? 0.03 : 0.0);
    // √(E (z_k - 2 z_k-1 + z_k-2)² / 6) = 20 mrad/s / √6; while moving, the estimate is at its
    // bound.
    EXPECT_NEAR(noise.at_rest, estimates ? 0.00816 : 0.0, 1e-4);
    EXPECT_NEAR(noise.moving, estimates ? 0.00949 : 0.0, 1e-4);
    EXPECT_EQ(sources[wheel].noise.get().speed_share > 0.0, estimates);
    EXPECT_FALSE(sources[camera].noise.get().estimated());
  }
}

TEST(Pipeline, GoesOnFromAPredecessorWithItsCalibrationsAndItsCovarianceGrown) {
  const Car first(two_signals(estimator::Model::full));
  TickRecord last;
  for (std::int64_t k = 0; k <= 600; ++k) {  // standing, while the gyro reads 20 mrad/s
    first.wheel_reads(k * 5, 0);
    first.gyro_reads(k * 5, 20, k);
    last = first.tick(k * 5);
  }
  EXPECT_NEAR(last.details.gyro_bias, 0.02, 1e-3);
  EXPECT_NE(last.details.calibration_valid & 1U, 0U);
  last.pose.x = last.pose.odom_x = 5.0;

  const Car second(two_signals(estimator::Model::full));
  second.pipeline->resume(last.pose, last.details, 100 * ms);
  second.wheel_reads(3105, 1000);
  const TickRecord& record = second.tick(3105);
  EXPECT_TRUE(record.initialised);
  EXPECT_NEAR(record.pose.x, 5.0, 0.2);
  EXPECT_GT(record.pose.covariance[0], last.pose.covariance[0]);
  EXPECT_GT(record.pose.reset_count, last.pose.reset_count);
  EXPECT_NEAR(record.details.gyro_bias, last.details.gyro_bias, 1e-3);
  EXPECT_NE(record.details.calibration_valid & 1U, 0U);
  EXPECT_LT(record.details.calibration_sigma[0], 1.5 * last.details.calibration_sigma[0]);
}

TEST(Pipeline, TakesASigmaThatIsNotPositiveForUnusableWhateverTheLeverArm) {
  Config arm = two_signals();
  arm.camera.lever_arm = {0.1, 0.2, 0.3};
  const Car car(arm, true);
  car.wheel_reads(0, 1000);
  (void)car.tick(0);
  estimator::CameraPose far = seen(50.0, 0, 0);
  car.pipeline->take(far);
  EXPECT_EQ(car.count(camera, Verdict::gated), 1U);
  far.sigma_x = -0.01;
  car.pipeline->take(far);
  far.sigma_x = 0.0;
  // A message that is not a pose does not affect the last pose.
  EXPECT_TRUE(car.rejects(far, 5));
  EXPECT_EQ(car.count(camera, Verdict::non_finite), 2U);
}

TEST(Pipeline, SaysThatTheCameraIsRejectedWhileItsClockIsAhead) {
  const Car car(two_signals(), true);
  car.wheel_reads(0, 1000);
  (void)car.tick(0);
  EXPECT_FALSE(car.rejects(seen(0.0, 0, 0, 1.0), 5));
  EXPECT_TRUE(car.rejects(seen(0.0, 200, 7, 1.0), 10));
  EXPECT_EQ(car.count(camera, Verdict::future), 1U);
  EXPECT_FALSE(car.rejects(seen(0.0, 9, 9, 1.0), 15));
}

TEST(Pipeline, FlagsASourceThatContradictsTheOthers) {
  const Car car;
  const TickRecord* record = nullptr;
  for (std::int64_t k = 0; k < 200; ++k) {
    car.gyro_reads(k * 5, static_cast<std::int16_t>(k % 3), k);  // the gyro has noise
    car.wheel_reads(k * 5, 1500);
    record = &car.tick(k * 5);
  }
  EXPECT_EQ(record->pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
  EXPECT_NE(record->pose.health >> wheel & 1U, 0U);

  // A signal of 16 bits cannot exceed physical limits here; but a frozen camera can.
  for (std::int64_t k = 200; k < 400; ++k) {
    car.wheel_reads(k * 5, static_cast<std::int16_t>(1500 + k % 3));
    car.pipeline->take(seen(1.0, k * 5 - 30, k * 5));
    record = &car.tick(k * 5);
  }
  EXPECT_NE(record->pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
  EXPECT_EQ(record->pose.health >> camera & 1U, 0U);
  EXPECT_EQ(record->pose.mode, static_cast<std::uint32_t>(ODOM_DEGRADED));
  EXPECT_EQ(car.flag(camera), estimator::SourceFlag::frozen);
  EXPECT_EQ(car.flag(gyro), estimator::SourceFlag::timed_out);
}

}  // namespace
}  // namespace odomd::daemon::pipeline_test
