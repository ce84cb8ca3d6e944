// The doctor on whole drives with deliberate mistakes.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <map>

#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/doctor/doctor.hpp"

namespace odomd::tools::doctor::whole_drive_test {
namespace {

using diagnostics::Diagnostics;
using diagnostics::Named;
using diagnostics::text_of;
using ::testing::Each;

constexpr auto slalom = "--scenario slalom --duration 22";

/// A drive of `odom sim` with these options, simulated once.
const SharedDrive& simulated(const std::string& options) {
  static std::map<std::string, SharedDrive> made;
  return made.try_emplace(options, options).first->second;
}

/// A replacement of all occurrences in car.toml.
struct Edit {
  std::string from, to;
};

std::string edited(std::string text, const Edit& edit) {
  std::size_t at = text.find(edit.from);
  EXPECT_NE(at, std::string::npos) << edit.from;
  for (; at != std::string::npos; at = text.find(edit.from, at + edit.to.size()))
    text.replace(at, edit.from.size(), edit.to);
  return text;
}

Drive drive_with(const std::vector<Edit>& edits, const std::string& options = slalom) {
  const SharedDrive& drive = simulated(options);
  std::string text = contents(drive.folder / "car.toml");
  for (const Edit& edit : edits) text = edited(std::move(text), edit);
  return read_drive(
      {.folder = drive.folder, .config = drive.scratch.write("drive/edited.toml", text)});
}

std::vector<Edit> exchange(const std::string& one, const std::string& other) {
  return {{one, "EXCHANGED"}, {other, one}, {"EXCHANGED", other}};
}

Diagnostics found_in(const Drive& drive) {
  return examine_drive(drive).diagnostics;
}

/// Expects findings of this kind only, the first of which names this key.
void expect_only(const Diagnostics& found, const std::string& name, const std::string& key) {
  ASSERT_THAT(found, Not(IsEmpty()));
  EXPECT_THAT(found, Each(Named(name)));
  EXPECT_THAT(text_of(found[0]), HasSubstr(key));
}

const std::string gyro = R"("YawRate", unit = "rad/s")";
const std::string steering = R"("SteeringAngle", unit = "rad")";
const std::string speed = R"(unit = "m/s",)";

// Mistakes of wiring, configuration and clocks, made in simulated drives: each is named once with
// the key that corrects it, and the unchanged drives have no finding.

const std::string accel = R"(unit = "m/s2",)";
const std::string across = R"("AccY", unit = "m/s2")";

class SoundDrive : public ::testing::TestWithParam<const char*> {};

TEST_P(SoundDrive, GivesNothing) {
  Drive drive = drive_with({}, GetParam());
  EXPECT_THAT(found_in(drive), IsEmpty());
  drive.reference.reset();
  drive.cameras.clear();
  EXPECT_THAT(found_in(drive), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    Of, SoundDrive,
    ::testing::Values("--scenario slalom --duration 22", "--scenario lap --laps 1",
                      "--scenario circle --duration 20", "--scenario stop-and-go --duration 30",
                      "--scenario parking --laps 1", "--car saloon --duration 40",
                      "--car bmw_320i --scenario lap --laps 1",
                      "--car ford_escort --scenario slalom --duration 40",
                      "--car vw_vanagon --scenario slalom --duration 40",
                      "--scenario road --duration 60 --seed 2"),
    [](const auto& test) { return "Drive" + std::to_string(test.index); });

TEST(Wiring, ThatIsWrongIsNamedAtItsKey) {
  std::vector<Edit> sides = exchange("\"WheelFrontLeft\"", "\"WheelFrontRight\"");
  const std::vector<Edit> rear = exchange("\"WheelRearLeft\"", "\"WheelRearRight\"");
  sides.insert(sides.end(), rear.begin(), rear.end());
  const std::vector<Edit> axles =
      exchange(R"("WHEELS_FRONT", signal = "WheelFront)", R"("WHEELS_REAR", signal = "WheelRear)");
  struct Mistake {
    std::vector<Edit> edits;
    std::string kind, key, options = slalom;
  };
  // Exchanged axles show in tight turns that are driven gently.
  for (const auto& [edits, kind, key, options] :
       {Mistake{{{gyro, gyro + ", scale = -1"}}, "wrong_sign", "yaw_rate.scale"},
        {{{steering, steering + ", scale = -1"}}, "wrong_sign", "steering.scale"},
        {{{across, across + ", scale = -1"}}, "wrong_sign", "accel_y.scale"},
        {exchange("\"AccX\"", "\"AccY\""), "axes_swapped", "accel_x"},
        {sides, "left_right_swapped", "wheel_front_left"},
        {axles, "front_rear_swapped", "wheel_front_left", "--scenario parking --laps 1"},
        {{{accel, accel + " scale = 0.102,"}}, "wrong_unit", "accel_x"},
        {{{speed, speed + " scale = 3.6,"}}, "wrong_unit", "wheel_front_left"},
        {{{gyro, gyro + ", scale = 57.3"}}, "wrong_unit", "yaw_rate"}})
    expect_only(found_in(drive_with(edits, options)), kind, "can.signals." + key);
}

TEST(Camera, OfAnotherMapUnitOrClockIsNamed) {
  struct Mistake {
    double scale, mirror, shift;
    const char *kind, *key;
  };
  for (const auto& [scale, mirror, shift, kind, key] :
       {Mistake{1e3, 1.0, 0.0, "positions_in_millimetres", "camera"},
        {1.0, -1.0, 0.0, "camera_mirrored", "camera"},
        {1.0, 1.0, 5.0, "initial_pose_elsewhere", "[initial] pose"}}) {
    Drive drive = drive_with({});
    for (auto& pose : drive.cameras) {
      pose.x = scale * pose.x + shift;
      pose.y *= scale * mirror;
      pose.yaw *= mirror;
    }
    expect_only(found_in(drive), kind, key);
  }
  // Another clock, even if there is no pose for it.
  Drive drive = drive_with({});
  drive.config.initial_pose.reset();
  for (estimator::CameraPose& pose : drive.cameras) {
    pose.capture_ns += 1'000'000'000'000;
    pose.arrival_ns += 1'000'000'000'000;
  }
  EXPECT_THAT(found_in(drive), ::testing::Contains(Named("camera_outside_log")));
}

TEST(Configuration, InOtherUnitsOrWithoutARoleIsNamedOnce) {
  EXPECT_THAT(found_in(drive_with({{"mass = 2.985", "mass = 2985"}})),
              ElementsAre(Named("mass_unlike_a_car", "mass in kilograms")));
  EXPECT_THAT(found_in(drive_with({{"axle = 0.175", "axle = 175"}, {"axle = 0.085", "axle = 85"}})),
              ElementsAre(Named("mass_unlike_a_car", "front_axle and rear_axle in metres")));
  EXPECT_THAT(found_in(drive_with({{"yaw_rate = {", "#"}})),
              ElementsAre(Named("role_not_mapped", "yaw_rate")));
  EXPECT_THAT(found_in(drive_with({{steering, steering + ", timeout = 0.005"}})),
              ElementsAre(Named("source_unused", "gave no value in its timeout",
                                HasSubstr("can.signals.steering"))));
  // Guesses of odom init.
  const Drive drive = drive_with({{"mass = 2.985", "mass = 2.985  # UNSURE: a guess"}});
  EXPECT_THAT(examine_drive(drive).note, StartsWith("1 line of edited.toml is marked UNSURE"));
}

TEST(Traffic, OfAnotherCarOrWithoutAMessageIsNamedAndNothingElseIs) {
  Drive drive = drive_with({});
  Drive other = drive;
  for (can::Frame& frame : other.frames) frame.id += 0x100;
  EXPECT_THAT(found_in(other), ElementsAre(Named("other_database", "can.dbc")));
  std::erase_if(drive.frames, [](const can::Frame& frame) { return frame.id == 0x1A3; });
  EXPECT_THAT(found_in(drive), ElementsAre(Named("message_missing", "steering")));
  drive.frames.clear();
  EXPECT_THAT(found_in(drive), ElementsAre(Named("no_frames", "drive")));
}

// A sensor's fault is reported for that sensor, not for the sensor that contradicts it.

TEST(Latency, ThatIsWrongGivesTheLineToWrite) {
  Diagnostics found = found_in(drive_with({{"latency = 0.005", "latency = 0.055"}}));
  expect_only(found, "latency_off", "can.signals.wheel_front_left.latency = 0.0");
  EXPECT_EQ(found.size(), 4U);
  found = found_in(drive_with({{gyro, gyro + ", latency = 0.05"}}));
  expect_only(found, "latency_off", "can.signals.yaw_rate.latency = 0.00");
  EXPECT_EQ(found.size(), 1U);
}

/// Delays each frame of a message.
void delay(Drive& drive, std::uint32_t id, std::int64_t by_ns) {
  for (can::Frame& frame : drive.frames)
    if (frame.id == id) frame.time_ns += by_ns;
  std::ranges::stable_sort(drive.frames, {}, &can::Frame::time_ns);
}

TEST(Latency, OfTheGyroIsNamedAtItWithAndWithoutACamera) {
  for (const auto* const course : {slalom, "--scenario lap --laps 1"})
    for (const int ms : {40, 300, 1200})
      for (const bool with_camera : {true, false}) {
        SCOPED_TRACE(std::string(course) + ' ' + std::to_string(ms) + (with_camera ? " c" : ""));
        Drive drive = drive_with({}, course);
        delay(drive, 0x1A2, ms * 1'000'000LL);
        if (!with_camera) {
          drive.cameras.clear();
          drive.reference.reset();
        }
        const Diagnostics found = found_in(drive);
        expect_only(found, "latency_off", "can.signals.yaw_rate.latency");
        EXPECT_EQ(found.size(), 1U);
      }
}

TEST(Culprit, IsNamedBeforeTheSensorThatContradictsIt) {
  Drive drive = drive_with({});
  for (estimator::CameraPose& pose : drive.cameras)
    pose.sigma_x = pose.sigma_y = pose.sigma_yaw = 1e-4;
  expect_only(found_in(drive), "sigma_off", "sigmas of its poses by");
}

TEST(Culprit, IsAGyroAtTheEndOfItsRange) {
  Drive drive = drive_with({});
  drive.config.can.protections.clear();
  constexpr std::uint64_t mask = (1U << 18U) - 1;
  constexpr std::int64_t end = 4500;  // 0.9 rad/s
  for (can::Frame& frame : drive.frames) {
    if (frame.id != 0x1A2) continue;
    std::uint64_t payload = 0;
    std::memcpy(&payload, frame.data.data(), sizeof payload);
    std::int64_t raw = static_cast<std::int64_t>(payload >> 12U & mask);
    if (raw >= 1 << 17) raw -= 1 << 18;
    raw = std::clamp(raw, -end, end);
    payload = (payload & ~(mask << 12U)) | (static_cast<std::uint64_t>(raw) & mask) << 12U;
    std::memcpy(frame.data.data(), &payload, sizeof payload);
  }
  expect_only(found_in(drive), "frozen", "the end of its range");
}

TEST(Latency, OfASignalWhoseMessageIsOnTimeIsNoFinding) {
  using estimator::Source;
  Drive drive = drive_with({});
  std::vector<SourceOffset> offsets{{Source::wheel_front_left, "", 0.001, 0.001, 1.0, ""},
                                    {Source::wheel_rear_left, "", 0.05, 0.001, 1.0, ""}};
  EXPECT_THAT(examine_latencies(drive.config, offsets),
              ElementsAre(Named("latency_off", "can.signals.wheel_rear_left.latency = 0.055")));
  EXPECT_EQ(latencies_unjudged(offsets), "");
  offsets[1].sigma = 0.006;
  EXPECT_THAT(examine_latencies(drive.config, offsets), IsEmpty());
  offsets[0].failure = "the signal never changes";
  EXPECT_EQ(latencies_unjudged(offsets),
            "latency of wheel_front_left not judged: the signal never changes; "
            "latency of wheel_rear_left not judged: too little driving");
  offsets[0].failure.clear();
  offsets[1].sigma = 0.001;
  for (can::SignalBinding& binding : drive.config.can.bindings) binding.message = "WHEELS";
  EXPECT_THAT(examine_latencies(drive.config, offsets), IsEmpty());
}

TEST(Latency, OfTheCameraIsAMatterOfItsClock) {
  for (const bool with_reference : {true, false}) {
    Drive drive = drive_with({});
    if (!with_reference) drive.reference.reset();
    for (auto& pose : drive.cameras) {
      pose.capture_ns += 50'000'000;
      pose.arrival_ns += 50'000'000;
    }
    expect_only(found_in(drive), "clocks_differ", "t_capture");
  }
}

constexpr auto ford = "--car ford_escort --scenario slalom --duration 40";
const std::vector<std::string> all_wheels{"wheel_front_left", "wheel_front_right",
                                          "wheel_rear_left", "wheel_rear_right"};

struct WrongScale {
  std::vector<std::string> signals;
  double factor;
  bool also_without_poses = true;  ///< found even so
};

// Replays flag the wrong sensor: the gyro, if all wheels have a wrong factor.
TEST(Scale, IsNamedAtItsSensorsWithAndWithoutPoses) {
  const std::vector<WrongScale> cases{{all_wheels, 0.8},
                                      {all_wheels, 1.25},
                                      {all_wheels, 0.621},  // miles read as kilometres
                                      {all_wheels, 0.9, false},
                                      {all_wheels, 1.1, false},
                                      {{all_wheels[0]}, 1.3},
                                      {{all_wheels[3]}, 0.85},
                                      {{all_wheels[0], all_wheels[1]}, 0.85},
                                      {{all_wheels[2], all_wheels[3]}, 1.2},
                                      {{"yaw_rate"}, 0.8},
                                      {{"yaw_rate"}, 1.25}};
  for (const auto* const course : {slalom, ford, "--scenario lap --laps 1 --seed 3"})
    for (const auto& [signals, factor, also_without_poses] : cases) {
      std::vector<Edit> edits;
      for (const std::string& signal : signals)
        edits.push_back({signal + " = {", fmt::format("{} = {{ scale = {},", signal, factor)});
      Drive drive = drive_with(edits, course);
      for (const char* const poses : {"camera", "truth", "none"}) {
        SCOPED_TRACE(fmt::format("{} {} {} {}", course, fmt::join(signals, ","), factor, poses));
        const SignalLog log = signals_of(drive);
        const auto found = find_wrong_scale(drive, log);
        if (drive.reference || !drive.cameras.empty() || also_without_poses) {
          ASSERT_TRUE(found);
          EXPECT_THAT(*found, Named("scale_off", fmt::format("{}", fmt::join(signals, ", "))));
        }
        drive.cameras.empty() ? drive.reference.reset() : drive.cameras.clear();
      }
    }
}

TEST(Scale, OfAllWheelsIsTheOnlyFinding) {
  for (const double factor : {0.5, 0.8, 1.1})
    expect_only(found_in(drive_with({{speed, fmt::format("{} scale = {},", speed, factor)}})),
                "scale_off", "radius of can.signals.wheel_front_left, can.signals.wheel_front_ri");
}

TEST(Latency, OfTheSteeringIsNamedAtIt) {
  struct Case {
    std::string course;
    std::vector<Edit> edits{};
  };
  const Edit actuator{"[can]\n", "[steering]\ndelay = 0.06\nlag = 0.1\n\n[can]\n"};
  for (const auto& [course, edits] :
       {Case{slalom}, Case{"--scenario lap --laps 1"}, Case{ford},
        Case{"--car saloon --duration 40"}, Case{std::string("--servo ") + slalom, {actuator}}})
    for (const char* late : {"0.06", "0.15", "0.3"}) {
      SCOPED_TRACE(course + ' ' + late);
      Drive drive = drive_with(edits, course + " --fix steering_latency=" + late);
      expect_only(found_in(drive), "latency_off", "can.signals.steering.latency = 0.");
      if (course != slalom) continue;
      drive.cameras.clear();
      drive.reference.reset();
      expect_only(found_in(drive), "latency_off", "can.signals.steering.latency = 0.");
    }
}

}  // namespace
}  // namespace odomd::tools::doctor::whole_drive_test
