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

Config config() {
  Config config;
  config.model = estimator::Model::kinematic;
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

std::unique_ptr<Pipeline> pipeline(const Config& config, bool camera_expected = false) {
  const std::vector<can::Database> databases{can::parse_dbc(bus, "test.dbc")};
  const std::vector<std::string> names{"can0", "can1"};
  return std::make_unique<Pipeline>(config, databases, names, camera_expected);
}

can::Frame frame(std::uint32_t id, std::int64_t time_ns, std::int16_t value,
                 std::uint8_t counter = 0) {
  can::Frame frame{.time_ns = time_ns, .id = id, .length = 2};
  const auto raw = std::bit_cast<std::uint16_t>(value);
  frame.data[0] = static_cast<std::uint8_t>(raw & 0xFFU);
  frame.data[1] = static_cast<std::uint8_t>(raw >> 8U);
  if (id == 256) frame.data[2] = counter, frame.length = 4;
  return frame;
}

std::uint64_t verdicts(const Pipeline& pipeline, std::size_t source, Verdict verdict) {
  return pipeline.statistics().sources[source].verdicts[static_cast<std::size_t>(verdict)].get();
}

TEST(Pipeline, DrivesStraightAheadAtTheWheelsSpeed) {
  const auto p = pipeline(config());
  const TickRecord* record = nullptr;
  for (std::int64_t k = 0; k <= 200; ++k) {
    const std::int64_t now = start + k * 5 * ms;
    p->take(frame(257, now, 1500), now);
    record = &p->tick(static_cast<std::uint64_t>(k), now);
  }
  EXPECT_TRUE(record->initialised);
  EXPECT_EQ(record->pose.tick, 200U);
  EXPECT_EQ(record->pose.time_ns, start + 1000 * ms);
  EXPECT_NEAR(record->pose.x, 1.5, 0.01);
  EXPECT_NEAR(record->pose.vx, 1.5, 1e-9);
  EXPECT_EQ(record->details.frames[0], 201U);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::fused), 201U);
}

TEST(Pipeline, IsNotInitialisedBeforeTheFirstWheelSample) {
  const auto p = pipeline(config());
  EXPECT_FALSE(p->tick(0, start).initialised);
  EXPECT_EQ(p->tick(1, start + 5 * ms).pose.mode, ODOM_INITIALISING);
}

TEST(Pipeline, WaitsForTheCameraWhereItIsToInitialise) {
  Config waiting = config();
  waiting.initial_pose.reset();
  const auto p = pipeline(waiting, true);
  p->take(frame(257, start, 0), start);
  EXPECT_FALSE(p->tick(0, start).initialised);

  p->take(estimator::CameraPose{.capture_ns = start,
                                .arrival_ns = start + 5 * ms,
                                .x = 2.0,
                                .y = 3.0,
                                .yaw = 0.5,
                                .sigma_x = 0.01,
                                .sigma_y = 0.01,
                                .sigma_yaw = 0.01});
  const TickRecord& record = p->tick(1, start + 5 * ms);
  EXPECT_TRUE(record.initialised);
  EXPECT_NEAR(record.pose.x, 2.0, 1e-9);
  EXPECT_NEAR(record.pose.yaw, 0.5, 1e-9);
  EXPECT_EQ(record.details.camera_messages, 1U);
  EXPECT_EQ(verdicts(*p, camera, Verdict::fused), 1U);
}

TEST(Pipeline, CountsValuesThatDoNotCount) {
  Config odd = config();
  odd.can.bindings[0].valid_when = {{"YawRate", 1.0, can::Comparison::below}};
  const auto p = pipeline(odd);
  p->take(frame(257, start, 32767), start);  // the first value, at an end of the range
  p->take(frame(256, start, 1000, 1), start);
  p->take(frame(257, start + 1 * ms, 500), start + 1 * ms);
  EXPECT_FALSE(p->tick(0, start + 5 * ms).pose.health & 1U << gyro);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::not_valid), 1U);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::fused), 1U);
  EXPECT_EQ(verdicts(*p, gyro, Verdict::not_valid), 1U);
  EXPECT_EQ(verdicts(*p, gyro, Verdict::fused), 0U);
}

TEST(Pipeline, AFrameThatFailsItsProtectionUpdatesNothing) {
  const auto p = pipeline(config());
  p->take(frame(257, start, 1000), start);
  p->take(frame(256, start, 100, 1), start);
  p->take(frame(256, start + 1 * ms, 200, 1), start + 1 * ms);  // the counter does not change
  const TickRecord& record = p->tick(0, start + 5 * ms);
  EXPECT_EQ(verdicts(*p, gyro, Verdict::failed_protection), 1U);
  EXPECT_TRUE(record.pose.conditions & ODOM_COND_PROTECTION);
  EXPECT_FALSE(record.pose.health & (1U << gyro));
  EXPECT_EQ(record.details.source_age_ns[gyro], 5 * ms);  // age of the good frame

  p->take(frame(256, start + 6 * ms, 300, 2), start + 6 * ms);
  EXPECT_FALSE(p->tick(1, start + 10 * ms).pose.conditions & ODOM_COND_PROTECTION);
}

TEST(Pipeline, CountsASampleThatAFloodPushedOut) {
  Config full = config();
  full.model = estimator::Model::full;
  const auto p = pipeline(full);
  (void)p->tick(0, start);
  constexpr std::int64_t flood = 3000;
  for (std::int64_t i = 1; i <= flood; ++i) p->take(frame(257, start + i, 1500), start + 5 * ms);
  (void)p->tick(1, start + 5 * ms);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::too_old) + verdicts(*p, wheel, Verdict::fused) +
                verdicts(*p, wheel, Verdict::gated),
            static_cast<std::uint64_t>(flood));
  EXPECT_EQ(verdicts(*p, wheel, Verdict::too_old), flood - 1024);
}

TEST(Pipeline, SaysWhichSourceIsOverdueAndDegrades) {
  const auto p = pipeline(config());
  p->take(frame(257, start, 1000), start);
  p->take(frame(256, start, 0, 1), start);
  const TickRecord& fresh = p->tick(0, start);
  EXPECT_EQ(fresh.pose.conditions, 0U);
  EXPECT_EQ(fresh.pose.health, (1U << gyro) | (1U << wheel));

  p->take(frame(257, start + 31 * ms, 1000), start + 31 * ms);
  const TickRecord& late = p->tick(1, start + 35 * ms);
  EXPECT_EQ(late.pose.conditions, static_cast<std::uint32_t>(ODOM_COND_SIGNAL_TIMEOUT));
  EXPECT_EQ(late.pose.health, 1U << wheel);
  EXPECT_EQ(late.pose.mode, ODOM_DEGRADED);
}

TEST(Pipeline, GivesStampsThatStandStillOrRunBackwardsAVerdictNotTrust) {
  const auto p = pipeline(config());
  p->take(frame(257, start, 1000), start);
  p->take(frame(257, start, 9000), start);
  p->take(frame(257, start - 1 * ms, 9000), start);
  EXPECT_NEAR(p->tick(0, start).pose.vx, 1.0, 1e-9);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::duplicate), 1U);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::too_old), 1U);
}

TEST(Pipeline, TimesFramesWithoutAUsableStampByTheirDrain) {
  const auto p = pipeline(config());
  p->take(frame(257, 0, 1000), start);
  EXPECT_EQ(p->tick(0, start + 2 * ms).details.source_age_ns[wheel], 2 * ms);
  p->take(frame(257, start + 900 * ms, 1000), start + 5 * ms);
  EXPECT_EQ(p->tick(1, start + 7 * ms).details.source_age_ns[wheel], 2 * ms);
  const auto& stamps = p->statistics().stamps;
  EXPECT_EQ(stamps[static_cast<std::size_t>(can::StampVerdict::zero)].get(), 1U);
  EXPECT_EQ(stamps[static_cast<std::size_t>(can::StampVerdict::future)].get(), 1U);
}

TEST(Pipeline, TakesFreshSamplesAfterSkippedTicks) {
  const auto p = pipeline(config());
  p->take(frame(257, start, 1000), start);
  p->tick(0, start);
  p->take(frame(257, start + 99 * ms, 2000), start + 100 * ms);  // 19 ticks were skipped
  p->tick(20, start + 100 * ms);
  EXPECT_EQ(verdicts(*p, wheel, Verdict::fused), 2U);
}

TEST(Pipeline, CountsTheFramesOfEachBusButNoErrorFrames) {
  const auto p = pipeline(config());
  can::Frame other = frame(0x7FF, start, 0);
  other.bus = 1;
  p->take(other, start);
  can::Frame error{.time_ns = start, .id = 4, .kind = can::FrameKind::error};
  p->take(error, start);
  const TickRecord& record = p->tick(0, start);
  EXPECT_EQ(record.details.frames[0], 0U);
  EXPECT_EQ(record.details.frames[1], 1U);
  EXPECT_EQ(p->statistics().frames[static_cast<std::size_t>(can::FrameVerdict::unmapped)].get(),
            1U);
}

TEST(Pipeline, PublishesTheConditionsOfItsSurroundings) {
  const auto p = pipeline(config());
  p->set_conditions(ODOM_COND_NOT_REALTIME);
  p->take(frame(257, start, 0), start);
  p->take(frame(256, start, 0, 1), start);
  EXPECT_EQ(p->tick(0, start).pose.conditions, static_cast<std::uint32_t>(ODOM_COND_NOT_REALTIME));
}

TEST(Pipeline, GoesOnFromAPredecessorWithItsCovarianceGrown) {
  const auto first = pipeline(config());
  first->take(frame(257, start, 1000), start);
  TickRecord last = first->tick(0, start);
  last.pose.x = 5.0;
  last.pose.odom_x = 5.0;

  const auto second = pipeline(config());
  second->resume(last.pose, last.details, 100 * ms);
  second->take(frame(257, start + 100 * ms, 1000), start + 100 * ms);
  const TickRecord& record = second->tick(1, start + 100 * ms);
  EXPECT_TRUE(record.initialised);
  EXPECT_NEAR(record.pose.x, 5.0, 0.2);
  EXPECT_GT(record.pose.covariance[0], last.pose.covariance[0]);
  EXPECT_GT(record.pose.reset_count, last.pose.reset_count);
}

TEST(Pipeline, HandsOutTheNoiseThatItsFilterEstimates) {
  Config full = config();
  full.model = estimator::Model::full;
  for (const Config& settings : {full, config()}) {
    const auto p = pipeline(settings);
    const auto& sources = p->statistics().sources;
    // The car stands for a second, then drives; the gyro alternates between 0 and 10 mrad/s.
    for (int k = 0; k <= 400; ++k) {
      const std::int64_t now = start + k * 5 * ms;
      const auto turn = static_cast<std::int16_t>(k % 2 * 10);
      p->take(frame(257, now, k < 200 ? 0 : 1500), now);
      p->take(frame(256, now, turn, static_cast<std::uint8_t>(k % 16)), now);
      p->tick(static_cast<std::uint64_t>(k), now);
      EXPECT_FALSE(k == 0 && sources[gyro].noise.get().estimated());
    }
    const estimator::SourceNoise noise = sources[gyro].noise.get();
    const bool estimates = settings.model == estimator::Model::full;
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

TEST(Pipeline, GoesOnWithTheCalibrationsOfAPredecessor) {
  Config full = config();
  full.model = estimator::Model::full;
  const auto first = pipeline(full);
  TickRecord last;
  std::uint64_t number = 0;
  std::int64_t now = start;
  std::uint8_t counter = 0;
  for (; now <= start + 3000 * ms; now += 5 * ms) {  // standing, while the gyro reads 20 mrad/s
    first->take(frame(257, now, 0), now);
    first->take(frame(256, now, 20, counter), now);
    counter = static_cast<std::uint8_t>((counter + 1) % 16);
    last = first->tick(number++, now);
  }
  EXPECT_NEAR(last.details.gyro_bias, 0.02, 1e-3);
  EXPECT_NE(last.details.calibration_valid & 1U, 0U);

  const auto second = pipeline(full);
  second->resume(last.pose, last.details, 100 * ms);
  now += 100 * ms;
  second->take(frame(257, now, 1000), now);
  const TickRecord& record = second->tick(number, now);
  EXPECT_NEAR(record.details.gyro_bias, last.details.gyro_bias, 1e-3);
  EXPECT_NE(record.details.calibration_valid & 1U, 0U);
  EXPECT_LT(record.details.calibration_sigma[0], 1.5 * last.details.calibration_sigma[0]);
}

TEST(Pipeline, TakesASigmaThatIsNotPositiveForUnusableWhateverTheLeverArm) {
  Config arm = config();
  arm.camera.lever_arm = {0.1, 0.2, 0.3};
  const auto p = pipeline(arm, true);
  p->take(frame(257, start, 1000), start);
  p->tick(0, start);
  estimator::CameraPose far{.capture_ns = start,
                            .arrival_ns = start,
                            .x = 50.0,
                            .sigma_x = 0.01,
                            .sigma_y = 0.01,
                            .sigma_yaw = 0.01};
  p->take(far);
  EXPECT_EQ(verdicts(*p, camera, Verdict::gated), 1U);
  far.sigma_x = -0.01;
  p->take(far);
  far.sigma_x = 0.0;
  p->take(far);
  EXPECT_EQ(verdicts(*p, camera, Verdict::non_finite), 2U);
  // A message that is not a pose does not affect the last pose.
  EXPECT_NE(p->tick(1, start + 5 * ms).pose.conditions & ODOM_COND_CAMERA_REJECTED, 0U);
}

TEST(Pipeline, SaysThatTheCameraIsRejectedWhileItsClockIsAhead) {
  const auto p = pipeline(config(), true);
  p->take(frame(257, start, 1000), start);
  p->tick(0, start);
  estimator::CameraPose pose{
      .capture_ns = start, .arrival_ns = start, .sigma_x = 1.0, .sigma_y = 1.0, .sigma_yaw = 1.0};
  p->take(pose);
  EXPECT_EQ(p->tick(1, start + 5 * ms).pose.conditions & ODOM_COND_CAMERA_REJECTED, 0U);
  pose.arrival_ns = start + 7 * ms;
  pose.capture_ns = start + 200 * ms;
  p->take(pose);
  EXPECT_EQ(verdicts(*p, camera, Verdict::future), 1U);
  EXPECT_NE(p->tick(2, start + 10 * ms).pose.conditions & ODOM_COND_CAMERA_REJECTED, 0U);
  pose.capture_ns = pose.arrival_ns = start + 9 * ms;
  p->take(pose);
  EXPECT_EQ(p->tick(3, start + 15 * ms).pose.conditions & ODOM_COND_CAMERA_REJECTED, 0U);
}

TEST(Pipeline, FlagsASourceThatContradictsTheOthers) {
  const auto p = pipeline(config());
  const TickRecord* record = nullptr;
  const auto drive = [&](std::int64_t from, std::int64_t to, std::int16_t speed) {
    for (std::int64_t k = from; k < to; ++k) {
      const std::int64_t now = start + k * 5 * ms;
      // The gyro has noise.
      p->take(frame(256, now, static_cast<std::int16_t>(k % 3), static_cast<std::uint8_t>(k % 16)),
              now);
      p->take(frame(257, now, speed), now);
      record = &p->tick(static_cast<std::uint64_t>(k), now);
    }
  };
  drive(0, 200, 1500);
  EXPECT_EQ(record->pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
  EXPECT_NE(record->pose.health >> wheel & 1U, 0U);

  // A signal of 16 bits cannot exceed physical limits here; but a frozen camera can.
  for (std::int64_t k = 200; k < 400; ++k) {
    const std::int64_t now = start + k * 5 * ms;
    p->take(frame(257, now, static_cast<std::int16_t>(1500 + k % 3)), now);
    p->take(estimator::CameraPose{.capture_ns = now - 30 * ms,
                                  .arrival_ns = now,
                                  .x = 1.0,
                                  .sigma_x = 0.01,
                                  .sigma_y = 0.01,
                                  .sigma_yaw = 0.01});
    record = &p->tick(static_cast<std::uint64_t>(k), now);
  }
  EXPECT_NE(record->pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
  EXPECT_EQ(record->pose.health >> camera & 1U, 0U);
  EXPECT_EQ(record->pose.mode, static_cast<std::uint32_t>(ODOM_DEGRADED));
  EXPECT_EQ(p->statistics().sources[camera].flag.get(),
            static_cast<std::uint64_t>(estimator::SourceFlag::frozen));
  EXPECT_EQ(p->statistics().sources[gyro].flag.get(),
            static_cast<std::uint64_t>(estimator::SourceFlag::timed_out));
}

}  // namespace
}  // namespace odomd::daemon::pipeline_test
