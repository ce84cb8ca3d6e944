// Kinds of faults as a command line names them, and the faults of the camera.
#include <set>

#include "tests/tools/fault/small_car.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/fault/fault.hpp"
#include "tools/fault/stream_faults.hpp"

namespace odomd::fault::camera_fault_test {
namespace {

using estimator::CameraPose;
using tools::message_of;

TEST(FaultKinds, EachHasAUniqueNameAndIsListed) {
  std::set<std::string> names;
  const std::string text = kinds_text();
  for (const FaultKind kind : all_kinds()) {
    EXPECT_TRUE(names.insert(name_of(kind)).second) << name_of(kind);
    EXPECT_EQ(parse_kind(name_of(kind)), kind);
    EXPECT_THAT(text, HasSubstr(std::string(info(kind.part).name)));
    EXPECT_THAT(text, HasSubstr(std::string(info(kind.act).what)));
  }
  EXPECT_GT(names.size(), 67U);
  const auto json = kinds_json();
  EXPECT_EQ(json.size(), all_kinds().size());
  EXPECT_EQ(json[0]["kind"], "gyro.frozen");
  EXPECT_TRUE(json[0]["size"].is_null());
  EXPECT_THAT(text, HasSubstr("0.2 rad/s, 3 m/s2"));
}

TEST(FaultKinds, SourcesAreThoseOfThePart) {
  using estimator::Source;
  EXPECT_EQ(sources_of(parse_kind("gyro.frozen")), only(Source::yaw_rate));
  EXPECT_TRUE(contains(sources_of(parse_kind("wheels.zero")), Source::motor));
  EXPECT_FALSE(contains(sources_of(parse_kind("front_wheels.zero")), Source::wheel_rear_left));
  EXPECT_EQ(sources_of(parse_kind("camera.lost")), only(Source::camera));
  EXPECT_EQ(sources_of(parse_kind("bus.shifted")), 0U);
}

TEST(FaultKinds, AFaultIsParsedAndAMistakeNamed) {
  const Fault whole = parse_fault("gyro.biased:10:5:-0.3");
  EXPECT_EQ(whole.kind, parse_kind("gyro.biased"));
  EXPECT_EQ(whole.begin_s, 10.0);
  EXPECT_EQ(whole.duration_s, 5.0);
  EXPECT_EQ(whole.magnitude, -0.3);
  const Fault rest = parse_fault("wheels.scaled:20::1.1");
  EXPECT_TRUE(std::isinf(rest.duration_s));
  EXPECT_EQ(rest.magnitude, 1.1);
  EXPECT_EQ(parse_fault("imu.lost").begin_s, 0.0);
  EXPECT_EQ(parse_fault("accel_x.biased").magnitude, 3.0);
  for (const auto& [word, says] : {std::pair{"gyro.zero:ten", "the begin \"ten\" is not a number"},
                                   {"gyro.zero:1:0", "has no duration"},
                                   {"gyro.zero:-1", "before the first frame"},
                                   {"gyro.zero:1:1:3", "has no size"},
                                   {"imu.bit_flips:::2", "0 to 1"},
                                   {"gyro.zero:1:1:3:4", "more parts than"}})
    EXPECT_THAT(message_of([&] { (void)parse_fault(word); }), HasSubstr(says));
  EXPECT_EQ(message_of([] { (void)parse_fault("bus.shifted:::-0.1"); }), "");
}

// Three seconds, a pose every 20 ms that arrives 50 ms after it was captured.
std::vector<CameraPose> healthy_poses() {
  std::vector<CameraPose> poses;
  for (std::int64_t at_ns = 0; at_ns < 3 * second_ns; at_ns += 20'000'000) {
    const double t = static_cast<double>(at_ns) * 1e-9;
    poses.push_back({.capture_ns = start_ns + at_ns - 50'000'000,
                     .arrival_ns = start_ns + at_ns,
                     .x = 2.0 * t,
                     .y = 1.0 + t,
                     .yaw = 0.3 * t,
                     .sigma_x = 0.01,
                     .sigma_y = 0.02,
                     .sigma_yaw = 0.005});
  }
  return poses;
}

const std::vector<CameraPose> old = healthy_poses();

std::vector<CameraPose> with(const Fault& fault, const std::vector<CameraPose>& poses) {
  CameraInjector injector(std::vector{fault}, start_ns);
  std::vector<CameraPose> out;
  for (const CameraPose& pose : poses) injector.take(pose, out);
  injector.release(end_of_time, out);
  return out;
}

std::vector<CameraPose> with(std::string_view kind) {
  return with(in_the_middle(kind), old);
}

bool same(const CameraPose& a, const CameraPose& b) {
  return a.capture_ns == b.capture_ns && a.arrival_ns == b.arrival_ns && a.x == b.x && a.y == b.y &&
         a.yaw == b.yaw && a.sigma_x == b.sigma_x && a.sigma_y == b.sigma_y &&
         a.sigma_yaw == b.sigma_yaw;
}

// 50 poses before the fault, 50 during it, 50 after it.
TEST(CameraFault, OutsideOfItsTimeNothingChanges) {
  int tried = 0;
  for (const FaultKind kind : all_kinds()) {
    if (kind.part != Part::camera || kind.act == Act::lost || kind.act == Act::delayed ||
        kind.act == Act::duplicated)
      continue;
    SCOPED_TRACE(name_of(kind));
    ++tried;
    const auto now = with(name_of(kind));
    ASSERT_EQ(now.size(), old.size());
    for (std::size_t i = 0; i < old.size(); ++i) {
      const bool inside = i >= 50 && i < 100;
      const bool good_yet = (kind.act == Act::outliers && i % 5 != 0) ||
                            ((kind.act == Act::drifting || kind.act == Act::skewed) && i == 50) ||
                            (kind.act == Act::mixed && (i % 2 == 0 || i == 51));
      EXPECT_EQ(same(now[i], old[i]), !inside || good_yet) << i;
    }
  }
  EXPECT_EQ(tried, 13);
}

TEST(CameraFault, FrozenPosesKeepTheirNewStamps) {
  const auto now = with("camera.frozen");
  EXPECT_EQ(now[75].x, old[49].x);
  EXPECT_EQ(now[75].y, old[49].y);
  EXPECT_EQ(now[75].yaw, old[49].yaw);
  EXPECT_EQ(now[75].capture_ns, old[75].capture_ns);
  const auto noisy = with("camera.frozen_noisy");
  EXPECT_NE(noisy[75].x, noisy[76].x);
  EXPECT_NEAR(noisy[75].x, old[49].x, 0.05);
  EXPECT_NEAR(noisy[75].yaw, old[49].yaw, 0.025);
}

TEST(CameraFault, PosesAndStampsAreOffByTheSize) {
  EXPECT_NEAR(with("camera.moved")[75].x, old[75].x + 0.5, 1e-12);
  EXPECT_NEAR(with("camera.turned")[75].yaw, old[75].yaw + 0.3, 1e-12);
  EXPECT_NEAR(with("camera.drifting")[75].x, old[75].x + 0.1 * 0.5, 1e-12);
  EXPECT_EQ(with("camera.mirrored")[75].y, -old[75].y);
  EXPECT_EQ(with("camera.mirrored")[75].yaw, -old[75].yaw);
  const auto outliers = with("camera.outliers");
  EXPECT_NEAR(std::hypot(outliers[55].x - old[55].x, outliers[55].y - old[55].y), 1.0, 1e-12);
  EXPECT_TRUE(same(outliers[56], old[56]));
  EXPECT_EQ(with("camera.early")[75].capture_ns, old[75].capture_ns - 50'000'000);
  EXPECT_EQ(with("camera.late")[75].capture_ns, old[75].capture_ns + 50'000'000);
  EXPECT_EQ(with("camera.late")[75].arrival_ns, old[75].arrival_ns);
  const auto skewed = with("camera.skewed");
  EXPECT_EQ(
      (skewed[60].capture_ns - old[60].capture_ns) - (skewed[85].capture_ns - old[85].capture_ns),
      2'500'000);  // 5 ms/s for half a second
}

TEST(CameraFault, PicturesComeInSwappedPairs) {
  const auto now = with("camera.mixed");
  std::size_t shifted = 0;
  for (std::size_t i = 55; i < 95; ++i) {
    EXPECT_EQ(now[i].capture_ns, old[i].capture_ns);
    shifted += now[i].x == old[i - 2].x ? 1U : 0U;
  }
  EXPECT_EQ(shifted, 20U);
}

TEST(CameraFault, NoiseHasTheStatedSigmas) {
  const auto now = with("camera.noisy");
  double x = 0.0;
  double yaw = 0.0;
  for (std::size_t i = 50; i < 100; ++i) {
    x += (now[i].x - old[i].x) * (now[i].x - old[i].x) / 50.0;
    yaw += (now[i].yaw - old[i].yaw) * (now[i].yaw - old[i].yaw) / 50.0;
  }
  EXPECT_NEAR(std::sqrt(x), 0.06, 0.02);
  EXPECT_NEAR(std::sqrt(yaw), 0.03, 0.01);
  EXPECT_EQ(now[75].sigma_x, 0.01);
  EXPECT_EQ(with("camera.vague")[75].sigma_x, 20.0 * old[75].sigma_x);
}

TEST(CameraFault, PosesComeLaterOrTwiceOrNotAtAll) {
  const auto late = with("camera.delayed");
  ASSERT_EQ(late.size(), old.size());
  const auto one = std::ranges::find(late, old[60].capture_ns, &CameraPose::capture_ns);
  ASSERT_NE(one, late.end());
  EXPECT_EQ(one->arrival_ns, old[60].arrival_ns + 100'000'000);
  EXPECT_TRUE(std::ranges::is_sorted(late, {}, &CameraPose::arrival_ns));
  EXPECT_EQ(with("camera.duplicated").size(), 200U);
  EXPECT_EQ(with("camera.lost").size(), 100U);
}

}  // namespace
}  // namespace odomd::fault::camera_fault_test
