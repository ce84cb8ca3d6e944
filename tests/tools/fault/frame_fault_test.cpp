// Every kind of fault on frames, checked with the daemon's decoder.
#include <functional>
#include <map>

#include "tests/tools/fault/small_car.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::fault::frame_fault_test {
namespace {

using can::FrameVerdict;

double step_of(Source source) {
  return std::ranges::find(small_car_signals, source, &Signal::source)->step;
}

// Expected value of a source, from its healthy value, the time since the fault began, the last
// healthy value before it, and the fault's size.
using Oracle = std::function<double(double value, double t, double before, double size)>;

const std::map<std::string_view, Oracle>& oracles() {
  static const std::map<std::string_view, Oracle> all{
      {"frozen", [](double, double, double before, double) { return before; }},
      {"zero", [](double, double, double, double) { return 0.0; }},
      {"stuck", [](double, double, double, double size) { return size; }},
      {"halved", [](double value, double, double, double) { return 0.5 * value; }},
      {"doubled", [](double value, double, double, double) { return 2.0 * value; }},
      {"scaled", [](double value, double, double, double) { return 1.3 * value; }},
      {"biased", [](double value, double, double, double size) { return value + size; }},
      {"ramped", [](double value, double t, double, double size) { return value + size * t; }},
      {"inverted", [](double value, double, double, double) { return -value; }},
  };
  return all;
}

// For each kind of fault: the faulty sources are as expected, other sources and times are unchanged
// to the bit, and no frame is refused.
TEST(FrameFault, ValuesAreChangedAndNothingElse) {
  const Decoded before = decoded(healthy_frames());
  int tried = 0;
  for (const FaultKind kind : all_kinds()) {
    const auto oracle = oracles().find(info(kind.act).name);
    if (oracle == oracles().end() || kind.part == Part::camera) continue;
    const bool mapped = std::ranges::any_of(small_car_signals, [&](const Signal& signal) {
      return contains(sources_of(kind), signal.source);
    });
    if (!mapped) continue;
    SCOPED_TRACE(name_of(kind));
    ++tried;
    const Decoded after = decoded(with({in_the_middle(name_of(kind))}));
    EXPECT_EQ(after.verdicts, before.verdicts);
    for (const Signal& signal : small_car_signals) {
      const auto& old = before.values.at(signal.source);
      const auto& now = after.values.at(signal.source);
      ASSERT_EQ(now.size(), old.size());
      for (std::size_t i = 0; i < old.size(); ++i) {
        const bool hit = contains(sources_of(kind), signal.source) && is_in_the_middle(old[i].t);
        const double wanted = hit ? oracle->second(old[i].value, old[i].t - 1.0, old[99].value,
                                                   default_magnitude(kind).value)
                                  : old[i].value;
        ASSERT_NEAR(now[i].value, wanted, hit ? 0.51 * signal.step : 0.0)
            << signal.name << " " << i;
      }
    }
  }
  EXPECT_GT(tried, 80);
}

TEST(FrameFault, NoiseHasTheStatedSigmaAndDependsOnTheSeed) {
  const auto old = decoded(healthy_frames()).values.at(Source::yaw_rate);
  Fault fault = in_the_middle("gyro.noisy");
  const auto now = [&fault](std::uint64_t seed) {
    fault.seed = seed;
    return decoded(with({fault})).values.at(Source::yaw_rate);
  };
  const auto one = now(1);
  EXPECT_EQ(one[150].value, now(1)[150].value);
  EXPECT_NE(one[150].value, now(2)[150].value);
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 100; i < 200; ++i) {
    const double noise = one[i].value - old[i].value;
    sum += noise;
    squares += noise * noise;
  }
  EXPECT_NEAR(sum / 100.0, 0.0, 0.02);
  EXPECT_NEAR(std::sqrt(squares / 100.0), 0.06, 0.015);  // 6 times 0.01
}

TEST(FrameFault, WheelsSpinUpOrLock) {
  const auto old = decoded(healthy_frames()).values;
  const auto now = decoded(with({in_the_middle("wheel_rear_left.slipping"),
                                 in_the_middle("wheel_front_right.locked")}))
                       .values;
  const auto ratio = [&](Source source, std::size_t i) {
    return now.at(source)[i].value / old.at(source)[i].value;
  };
  EXPECT_NEAR(ratio(Source::wheel_rear_left, 100), 1.0, 0.02);
  EXPECT_GT(ratio(Source::wheel_rear_left, 150), 1.45);
  EXPECT_EQ(ratio(Source::wheel_rear_left, 200), 1.0);
  EXPECT_NEAR(ratio(Source::wheel_front_right, 100), 1.0, 0.02);
  EXPECT_LT(ratio(Source::wheel_front_right, 150), 0.05);
  EXPECT_EQ(ratio(Source::wheel_rear_right, 150), 1.0);
}

// Each signal takes the newest value of the other, from the same frame if that contains both.
TEST(FrameFault, SignalsAreExchanged) {
  const auto old = decoded(healthy_frames()).values;
  const auto sides = decoded(with({in_the_middle("wheels.left_right")})).values;
  const auto axles = decoded(with({in_the_middle("wheels.front_rear")})).values;
  const auto axes = decoded(with({in_the_middle("accel.axes_swapped")})).values;
  const auto near = [](double a, double b) { return std::abs(a - b) < 2e-3; };
  for (const std::size_t i : {100U, 150U, 199U}) {
    EXPECT_EQ(sides.at(Source::wheel_rear_left)[i].value,
              old.at(Source::wheel_rear_right)[i].value);
    EXPECT_EQ(sides.at(Source::wheel_front_right)[i].value,
              old.at(Source::wheel_front_left)[i].value);
    // The front frame precedes the rear frame, so it gets the rear value of the previous cycle.
    EXPECT_EQ(axles.at(Source::wheel_front_left)[i].value,
              old.at(Source::wheel_rear_left)[i - 1].value);
    EXPECT_EQ(axles.at(Source::wheel_rear_right)[i].value,
              old.at(Source::wheel_front_right)[i].value);
    EXPECT_TRUE(near(axes.at(Source::accel_x)[i].value, old.at(Source::accel_y)[i].value));
    EXPECT_TRUE(near(axes.at(Source::accel_y)[i].value, old.at(Source::accel_x)[i].value));
  }
  EXPECT_EQ(sides.at(Source::wheel_rear_left)[99].value, old.at(Source::wheel_rear_left)[99].value);
  EXPECT_EQ(axes.at(Source::yaw_rate)[150].value, old.at(Source::yaw_rate)[150].value);
}

// The counter of the first frame after the gap has jumped; the next frame is good again.
TEST(FrameFault, LostFramesAreMissing) {
  const Decoded now = decoded(with({in_the_middle("imu.lost")}));
  EXPECT_EQ(now.values.at(Source::yaw_rate).size(), 199U);
  EXPECT_EQ(now.values.at(Source::steering).size(), 300U);
  EXPECT_EQ(now.verdicts.at(FrameVerdict::wrong_sequence), 1);
  const auto& left = now.values.at(Source::accel_x);
  EXPECT_TRUE(std::ranges::none_of(left, [](const Value& one) { return is_in_the_middle(one.t); }));
}

// Delayed frames come a tenth of a second later, in their original order; the frames after the
// fault wait for the last of them.
TEST(FrameFault, DelayedFramesComeLaterInTheirOrder) {
  const auto old = decoded(healthy_frames()).values.at(Source::steering);
  const auto frames = with({in_the_middle("steering.delayed")});
  const Decoded now = decoded(frames);
  EXPECT_THAT(now.verdicts, ElementsAre(Pair(FrameVerdict::decoded, 1200)));
  const auto& late = now.values.at(Source::steering);
  ASSERT_EQ(late.size(), old.size());
  for (std::size_t i = 0; i < old.size(); ++i) {
    EXPECT_EQ(late[i].value, old[i].value);
    if (is_in_the_middle(old[i].t)) {
      EXPECT_NEAR(late[i].t, old[i].t + 0.1, 1e-9);
    }
    if (i > 0) {
      EXPECT_GT(late[i].t, late[i - 1].t);
    }
  }
  EXPECT_NEAR(late[200].t, late[199].t, 1e-5);
  EXPECT_EQ(late[250].t, old[250].t);
  EXPECT_TRUE(std::ranges::is_sorted(frames, {}, &can::Frame::time_ns));
}

TEST(FrameFault, DuplicatesHaveCountersOfTheirOwn) {
  const Decoded now = decoded(with({in_the_middle("wheels.duplicated")}));
  EXPECT_THAT(now.verdicts, ElementsAre(Pair(FrameVerdict::decoded, 1400)));
  const auto& values = now.values.at(Source::wheel_rear_left);
  ASSERT_EQ(values.size(), 400U);
  EXPECT_EQ(values[100].value, values[101].value);
  EXPECT_GT(values[101].t, values[100].t);
}

TEST(FrameFault, ReorderedFramesComeInPairs) {
  const auto old = decoded(healthy_frames()).values.at(Source::wheel_front_left);
  const Decoded now = decoded(with({in_the_middle("wheels.reordered")}));
  EXPECT_THAT(now.verdicts, ElementsAre(Pair(FrameVerdict::decoded, 1200)));
  const auto& values = now.values.at(Source::wheel_front_left);
  EXPECT_EQ(values[100].value, old[101].value);
  EXPECT_EQ(values[101].value, old[100].value);
  EXPECT_GT(values[101].t, values[100].t);
  EXPECT_EQ(values[200].value, old[200].value);
  // A frame that waits for its partner is not lost when the fault ends.
  Fault fault = in_the_middle("steering.reordered");
  fault.duration_s = 0.05;
  EXPECT_EQ(decoded(with({fault})).values.at(Source::steering).size(), 300U);
  fault.duration_s = 100.0;
  fault.begin_s = 2.95;
  EXPECT_EQ(decoded(with({fault})).values.at(Source::steering).size(), 300U);
}

TEST(FrameFault, JitterChangesStampsAndKeepsTheOrder) {
  const auto old = decoded(healthy_frames()).values.at(Source::yaw_rate);
  Fault fault = in_the_middle("imu.jittered");
  fault.magnitude = 0.02;
  const Decoded now = decoded(with({fault}));
  EXPECT_THAT(now.verdicts, ElementsAre(Pair(FrameVerdict::decoded, 1200)));
  const auto& values = now.values.at(Source::yaw_rate);
  double early = 0.0;
  double late = 0.0;
  for (std::size_t i = 0; i < old.size(); ++i) {
    EXPECT_EQ(values[i].value, old[i].value);
    if (i > 100) {
      EXPECT_GT(values[i].t, values[i - 1].t);
    }
    early = std::min(early, values[i].t - old[i].t);
    late = std::max(late, values[i].t - old[i].t);
  }
  EXPECT_LT(early, -0.005);
  EXPECT_GE(early, -0.02 - 1e-9);
  EXPECT_GT(late, 0.01);
}

TEST(FrameFault, TheWholeBusIsStampedEarly) {
  const auto frames = healthy_frames();
  const auto now = with({in_the_middle("bus.shifted")});
  ASSERT_EQ(now.size(), frames.size());
  EXPECT_EQ(now[399].time_ns, frames[399].time_ns);
  EXPECT_EQ(now[400].time_ns, frames[400].time_ns - 50'000'000);
  EXPECT_EQ(now[401].time_ns, frames[401].time_ns - 50'000'000);
  EXPECT_EQ(now[800].time_ns, frames[800].time_ns);
}

// About every tenth frame has one wrong bit in the fault's signals: the CRC detects them all.
TEST(FrameFault, BitFlipsAreRefusedUnlessTheyAreRepaired) {
  const auto frames = healthy_frames();
  const auto flipped = with({in_the_middle("imu.bit_flips")});
  int bits = 0;
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (std::size_t byte = 0; byte < 8; ++byte)
      bits += std::popcount(static_cast<unsigned>(frames[i].data[byte] ^ flipped[i].data[byte]));
  EXPECT_GT(bits, 3);
  EXPECT_LT(bits, 25);
  EXPECT_EQ(decoded(flipped).verdicts.at(FrameVerdict::failed_crc), bits);

  const Decoded repaired = decoded(with({in_the_middle("imu.bit_flips_repaired")}));
  EXPECT_THAT(repaired.verdicts, ElementsAre(Pair(FrameVerdict::decoded, 1200)));
  const auto old = decoded(frames).values;
  int wrong = 0;
  for (const Source source : {Source::yaw_rate, Source::accel_x, Source::accel_y})
    for (std::size_t i = 0; i < 300; ++i)
      wrong += repaired.values.at(source)[i].value != old.at(source)[i].value ? 1 : 0;
  EXPECT_GT(wrong, 3);
  EXPECT_LT(wrong, 25);
}

TEST(FrameFault, SeveralActInTheGivenOrder) {
  const auto old = decoded(healthy_frames()).values.at(Source::yaw_rate);
  Fault bias = in_the_middle("gyro.biased");
  const auto scaled_last = decoded(with({bias, in_the_middle("gyro.doubled")}));
  const auto biased_last = decoded(with({in_the_middle("gyro.doubled"), bias}));
  const double step = step_of(Source::yaw_rate);
  EXPECT_NEAR(scaled_last.values.at(Source::yaw_rate)[150].value, 2.0 * (old[150].value + 0.2),
              2.0 * step);
  EXPECT_NEAR(biased_last.values.at(Source::yaw_rate)[150].value, 2.0 * old[150].value + 0.2,
              2.0 * step);
  EXPECT_THAT(biased_last.verdicts, ElementsAre(Pair(FrameVerdict::decoded, 1200)));
}

// A frame with a wrong CRC keeps a wrong CRC.
TEST(FrameFault, AnInvalidFrameStaysInvalid) {
  std::vector<can::Frame> frames = healthy_frames();
  const auto imu = std::ranges::find(frames, 418U, &can::Frame::id);
  for (auto& frame : frames)
    if (frame.id == imu->id && frame.time_ns > start_ns + 1'500'000'000 &&
        frame.time_ns < start_ns + 1'510'000'000)
      frame.data[0] ^= 1U;
  const std::vector<Fault> faults{in_the_middle("gyro.zero")};
  EXPECT_EQ(decoded(with(small_car(), faults, frames)).verdicts.at(FrameVerdict::failed_crc), 1);
}

// Frames of other nodes and those that are not data frames pass unchanged, at their places.
TEST(FrameFault, UnmappedFramesAreUnchanged) {
  std::vector<can::Frame> frames = healthy_frames();
  can::Frame other = frames[500];
  other.id = 0x123;
  frames.insert(frames.begin() + 500, other);
  can::Frame error = other;
  error.kind = can::FrameKind::error;
  frames.insert(frames.begin() + 501, error);
  const std::vector<Fault> faults{in_the_middle("imu.zero"), in_the_middle("wheels.bit_flips")};
  const auto now = with(small_car(), faults, frames);
  ASSERT_EQ(now.size(), frames.size());
  EXPECT_EQ(now[500].data, other.data);
  EXPECT_EQ(now[501].kind, can::FrameKind::error);
  const std::vector<Fault> silent{in_the_middle("bus.lost")};
  EXPECT_EQ(with(small_car(), silent, frames).size(), 800U);
}

TEST(FrameFault, AnUnmappedSourceIsNamedWithItsKey) {
  EXPECT_EQ(tools::message_of([] { (void)with({in_the_middle("motor.frozen")}); }),
            "car.toml: [can.signals] maps no motor, which motor.frozen needs; map it there");
}

}  // namespace
}  // namespace odomd::fault::frame_fault_test
