// The decoder: it compiles bindings, gives verdicts and values of frames, and never allocates while
// decoding.
#include "can_protocol/decode/decoder.hpp"

#include <fmt/format.h>

#include <numbers>
#include <tuple>

#include "can_protocol/decode/e2e.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "can_protocol/decode/units.hpp"
#include "tests/allocation_count.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::decoder_test {
namespace {

using testing::DoubleEq;
using testing::FieldsAre;

using Values = std::vector<std::pair<int, double>>;

/// A decoder for `car`, and the result of the last frame.
class Rig {
 public:
  explicit Rig(std::vector<SignalBinding> bindings, std::vector<E2eBinding> protections = {},
               std::vector<std::string> buses = {"can0", "can1"})
      : databases_{parse_dbc(car, "car.dbc")}, decoder_(databases_, bindings, protections, buses) {}

  FrameVerdict decode(const Frame& frame) {
    std::array<Sample, max_samples_per_frame> samples;
    const DecodeResult result = decoder_.decode(frame, samples);
    samples_.assign(samples.begin(), samples.begin() + result.count);
    EXPECT_EQ(result.count > 0, result.verdict == FrameVerdict::decoded);
    return result.verdict;
  }

  /// By channel.
  Values values_of(const Frame& frame) {
    decode(frame);
    Values values;
    for (const Sample& sample : samples_) values.emplace_back(sample.channel, sample.value);
    return values;
  }
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] const Decoder& decoder() const { return decoder_; }

  [[nodiscard]] MessageEncoder encoder(std::string_view message) const {
    return MessageEncoder(*find_message(databases_[0], message));
  }
  /// Of protected frames.
  [[nodiscard]] MessageEncoder imu(const E2eBinding& e2e) const {
    return {*find_message(databases_[0], "IMU"), e2e};
  }

 private:
  std::vector<Database> databases_;
  Decoder decoder_;
  std::vector<Sample> samples_;
};

Frame raw_frame(std::uint32_t id, IdFormat format, std::vector<std::uint8_t> payload) {
  Frame frame{.time_ns = 1'000,
              .id = id,
              .format = format,
              .length = static_cast<std::uint8_t>(payload.size())};
  std::copy(payload.begin(), payload.end(), frame.data.begin());
  return frame;
}

TEST(Decoder, ConvertsUnitsThenScaleThenOffset) {
  SignalBinding yaw = bind(1, "IMU", "Yaw", Unit::deg_per_s);
  yaw.scale = -2.0;
  yaw.offset = 0.25;
  yaw.latency_ns = 300;
  SignalBinding right = bind(4, "WHEELS", "Right");
  right.valid_when = {{"Fault", 2.0}};  // does not affect the other wheel
  Rig rig({yaw, bind(2, "IMU", "Acc", Unit::g), bind(3, "WHEELS", "Left", Unit::km_per_h), right});

  MessageEncoder imu = rig.encoder("IMU");
  imu.set("Yaw", 90.0);
  imu.set("Acc", -0.5);
  EXPECT_THAT(
      rig.values_of(imu.frame(10'000)),
      ElementsAre(Pair(1, DoubleEq(-std::numbers::pi + 0.25)), Pair(2, DoubleEq(-0.5 * 9.80665))));
  EXPECT_EQ(rig.samples()[0].time_ns, 9'700);
  EXPECT_EQ(rig.samples()[1].time_ns, 10'000);

  MessageEncoder wheels = rig.encoder("WHEELS");
  wheels.set("Left", 36.0);
  EXPECT_THAT(rig.values_of(wheels.frame(0)), ElementsAre(Pair(3, DoubleEq(10.0))));
}

TEST(Decoder, ConvertsRotationsOfAWheelToItsSpeed) {
  const std::vector<Database> databases{
      parse_dbc("BO_ 1 M: 8 X\n SG_ V : 0|32@1+ (0.01,0) [0|0] \"\" X\n", "car.dbc")};
  constexpr double radius = 0.05;
  for (const double omega : {0.0, 1.0, 40.0, 250.0})  // rad/s of the wheel
    for (const auto& [unit, value, ratio] :
         {std::tuple{Unit::rad_per_s, omega, 1.0},
          {Unit::rad_per_s, 8.0 * omega, 8.0},
          {Unit::deg_per_s, omega * 180.0 / std::numbers::pi, 1.0},
          {Unit::rpm, omega * 30.0 / std::numbers::pi, 1.0},
          {Unit::erpm, 7.0 * 8.0 * omega * 30.0 / std::numbers::pi, 7.0 * 8.0}}) {
      SignalBinding wheel = bind(1, "M", "V", unit);
      wheel.radius_m = radius;
      wheel.ratio = ratio;
      Decoder decoder(databases, std::vector{wheel}, {}, {});
      MessageEncoder encoder(databases[0].messages[0]);
      encoder.set("V", value);
      std::array<Sample, max_samples_per_frame> samples;
      ASSERT_EQ(decoder.decode(encoder.frame(0), samples).count, 1);
      EXPECT_NEAR(samples[0].value, radius * omega, 1e-3 * radius) << unit_name(unit);
    }
}

TEST(Decoder, ConvertsADirection) {
  SignalBinding gear = bind(1, "STEER", "Gear");
  gear.forward = 1.0;
  gear.reverse = 2.0;
  gear.scale = 100.0;  // does not apply to gears
  Rig rig({gear});
  MessageEncoder steer = rig.encoder("STEER");
  for (const auto& [raw, direction] : Values{{1, 1.0}, {2, -1.0}, {0, 0.0}, {7, 0.0}}) {
    steer.set_bits("Gear", static_cast<std::uint64_t>(raw));
    EXPECT_THAT(rig.values_of(steer.frame(0)), ElementsAre(Pair(1, direction)));
  }
}

TEST(Decoder, DecodesMultiplexedSignalsOnlyIfPresent) {
  Rig rig({bind(1, "MIXED", "Speed", Unit::m_per_s)});
  EXPECT_THAT(rig.values_of(raw_frame(33, IdFormat::standard, {2, 40, 0})),
              ElementsAre(Pair(1, 10.0)));
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {3, 40, 0})), FrameVerdict::no_sample);
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {2})), FrameVerdict::too_short);
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {3})), FrameVerdict::no_sample);
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {})), FrameVerdict::too_short);
  Rig never({bind(1, "MIXED", "Lost")});
  for (const std::uint8_t page : std::vector<std::uint8_t>{0, 1, 15})
    EXPECT_EQ(never.decode(raw_frame(33, IdFormat::standard, {page, 7})), FrameVerdict::no_sample);
}

TEST(Decoder, RejectsAPayloadThatEndsBeforeABoundSignal) {
  Rig rig({bind(1, "WHEELS", "Left"), bind(2, "WHEELS", "Right")});
  const Frame whole = raw_frame(416, IdFormat::extended, {1, 0, 2, 0});
  EXPECT_EQ(rig.decode(whole), FrameVerdict::decoded);  // unbound signals may be missing
  EXPECT_EQ(rig.decode(raw_frame(416, IdFormat::extended, {1, 0, 2})), FrameVerdict::too_short);
  Frame longer = whole;
  longer.length = 64;
  EXPECT_EQ(rig.decode(longer), FrameVerdict::decoded);
  longer.length = 255;  // longer than any frame: the decoder must not read beyond the end
  EXPECT_EQ(rig.decode(longer), FrameVerdict::decoded);
}

TEST(Decoder, DistinguishesIdentifiersOfBothFormats) {
  Rig rig({bind(1, "IMU", "Yaw"), bind(2, "WHEELS", "Left")});
  const std::vector<std::uint8_t> zeros(8);
  EXPECT_THAT(rig.values_of(raw_frame(416, IdFormat::standard, zeros)), ElementsAre(Pair(1, 0.0)));
  EXPECT_THAT(rig.values_of(raw_frame(416, IdFormat::extended, zeros)), ElementsAre(Pair(2, 0.0)));
  for (const std::uint32_t id : {0U, 415U, 417U, 2047U, 2048U, 0xFFFF'FFFFU}) {
    EXPECT_EQ(rig.decode(raw_frame(id, IdFormat::standard, zeros)), FrameVerdict::unmapped);
    EXPECT_EQ(rig.decode(raw_frame(id, IdFormat::extended, zeros)), FrameVerdict::unmapped);
  }
}

TEST(Decoder, AcceptsDataFramesOfTheBoundBusOnly) {
  SignalBinding left = bind(1, "WHEELS", "Left");
  left.bus = "can1";
  Rig rig({left, bind(2, "IMU", "Yaw")});
  Frame wheels = raw_frame(416, IdFormat::extended, std::vector<std::uint8_t>(8));
  EXPECT_EQ(rig.decode(wheels), FrameVerdict::unmapped);
  wheels.bus = 1;
  EXPECT_EQ(rig.decode(wheels), FrameVerdict::decoded);
  Frame imu = raw_frame(416, IdFormat::standard, std::vector<std::uint8_t>(8));
  for (const FrameKind kind : {FrameKind::remote, FrameKind::error}) {
    imu.kind = kind;
    EXPECT_EQ(rig.decode(imu), FrameVerdict::unmapped);
  }
  imu.kind = FrameKind::data;
  imu.bus = 200;
  EXPECT_EQ(rig.decode(imu), FrameVerdict::unmapped);
}

TEST(Decoder, FindsMessagesInSeveralDatabases) {
  const auto database = [](const char* head, const char* scale) {
    return parse_dbc(fmt::format("BO_ {}: 1 X\n SG_ S : 0|8@1+ ({},0) [0|0] \"\" X\n", head, scale),
                     "car.dbc");
  };
  // A binding uses the first database that has a message of this name.
  const std::vector databases{database("7 A", "1"), database("7 B", "2"), database("8 A", "1")};
  std::vector<SignalBinding> bindings{bind(1, "A", "S"), bind(2, "B", "S")};
  const std::vector<std::string> buses{"can0", "can1"};
  // Two messages may share an identifier on different buses.
  EXPECT_THROW(Decoder(databases, bindings, {}, buses), std::invalid_argument);
  bindings[0].bus = "can0";
  bindings[1].bus = "can1";
  Decoder decoder(databases, bindings, {}, buses);
  std::array<Sample, max_samples_per_frame> samples;
  Frame frame = raw_frame(7, IdFormat::standard, {5});
  for (const std::uint8_t bus : std::vector<std::uint8_t>{0, 1}) {
    frame.bus = bus;
    EXPECT_EQ(decoder.decode(frame, samples).verdict, FrameVerdict::decoded);
    EXPECT_EQ(samples[0].channel, bus + 1);
    EXPECT_EQ(samples[0].value, 5.0 * (bus + 1));
  }
}

TEST(Decoder, ListsItsMessages) {
  const Rig rig({bind(5, "IMU", "Yaw"), bind(6, "WHEELS", "Left"), bind(7, "IMU", "Acc")});
  EXPECT_THAT(
      rig.decoder().messages(),
      ElementsAre(
          FieldsAre("IMU", 416U, IdFormat::standard, 5'000'000, ElementsAre(5, 7), whole_id),
          FieldsAre("WHEELS", 416U, IdFormat::extended, 0, ElementsAre(6), whole_id)));
}

// Protection --------------------------------------------------------------------------------------

TEST(Decoder, GivesEveryProtectedFrameItsVerdictAndCountsIt) {
  Rig rig({bind(1, "IMU", "Yaw")}, {imu_protection()});
  MessageEncoder imu = rig.imu(imu_protection());
  Frame first = imu.frame(100);
  EXPECT_EQ(rig.decode(first), FrameVerdict::decoded);
  EXPECT_EQ(rig.decode(first), FrameVerdict::repeated);
  first.bus = 1;  // each bus has a state of its own
  EXPECT_EQ(rig.decode(first), FrameVerdict::decoded);
  Frame broken = imu.frame(200);
  broken.data[4] ^= 1U;
  EXPECT_EQ(rig.decode(broken), FrameVerdict::failed_crc);
  Frame behind_error = imu.frame(250);
  behind_error.bus = 1;
  EXPECT_EQ(rig.decode(behind_error), FrameVerdict::decoded);  // one frame was lost: OKSOMELOST
  behind_error.bus = 0;
  EXPECT_EQ(rig.decode(behind_error), FrameVerdict::distrusted);
  for (int i = 0; i < 5; ++i) (void)imu.frame(0);
  EXPECT_EQ(rig.decode(imu.frame(400)), FrameVerdict::wrong_sequence);
  EXPECT_EQ(rig.decode(imu.frame(500)), FrameVerdict::decoded);
  Frame cut = imu.frame(600);
  cut.length = 7;
  EXPECT_EQ(rig.decode(cut), FrameVerdict::too_short);

  const MessageCounters& counters = rig.decoder().counters(0);
  std::array<std::uint64_t, frame_verdict_count> counts;
  std::ranges::transform(counters.verdicts, counts.begin(), &Counter::get);
  EXPECT_THAT(counts, ElementsAre(4, 0, 0, 1, 1, 1, 1, 1)) << "in the order of the verdicts";
  EXPECT_EQ(counters.some_lost.get(), 1U);
  EXPECT_EQ(counters.last_time_ns.get(), 500U);
}

TEST(E2eTrust, ReturnsAtOnceAfterFewFailuresAndLaterAfterMany) {
  E2eTrust trust;
  const auto fail = [&](int times) {
    for (int i = 0; i < times; ++i) (void)trust.after(E2eStatus::error);
  };
  const auto refused = [&] {
    int frames = 0;
    while (!trust.after(E2eStatus::ok)) ++frames;
    return frames;
  };
  fail(E2eTrust::max_failed);
  EXPECT_EQ(refused(), 1) << "the one right after an error";
  for (int i = 0; i < E2eTrust::window; ++i) EXPECT_TRUE(trust.after(E2eStatus::ok));
  fail(E2eTrust::window);
  EXPECT_EQ(refused(), E2eTrust::window - E2eTrust::max_failed - 1);
}

TEST(E2eTrust, SurvivesAGatewayThatRepeatsEveryFrame) {
  E2eTrust trust;
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(trust.after(E2eStatus::ok));
    EXPECT_TRUE(trust.after(E2eStatus::repeated));
  }
}

TEST(Decoder, FindsAMessageByLongAndShortNames) {
  const std::vector<Database> databases{
      parse_dbc(std::string(car) + "BA_ \"SystemMessageLongSymbol\" BO_ 416 \"INERTIAL_SENSOR\";\n"
                                   "BA_ \"SystemSignalLongSymbol\" SG_ 416 Yaw \"YAW_RATE\";\n",
                "car.dbc")};
  const std::vector bindings{bind(1, "IMU", "YAW_RATE"), bind(2, "INERTIAL_SENSOR", "Acc"),
                             bind(3, "INERTIAL_SENSOR", "Yaw")};
  Decoder decoder(databases, bindings, std::vector{imu_protection()}, {});
  ASSERT_EQ(decoder.messages().size(), 1U);
  EXPECT_EQ(decoder.messages()[0].name, "INERTIAL_SENSOR");

  MessageEncoder imu(databases[0].messages[0], imu_protection());
  imu.set("Yaw", 1.5);
  std::array<Sample, max_samples_per_frame> samples;
  EXPECT_EQ(decoder.decode(imu.frame(0), samples).count, 3);
  EXPECT_EQ(samples[0].value, samples[2].value);
  Frame corrupt = imu.frame(1);
  corrupt.data[3] ^= 1U;
  EXPECT_EQ(decoder.decode(corrupt, samples).verdict, FrameVerdict::failed_crc);

  E2eBinding same = imu_protection();
  same.message = "INERTIAL_SENSOR";
  EXPECT_THROW(Decoder(databases, bindings, std::vector{imu_protection(), same}, {}),
               std::invalid_argument);
}

TEST(Decoder, NeverAllocatesWhileDecoding) {
  SignalBinding gated = bind(3, "WHEELS", "Left", Unit::km_per_h);
  gated.valid_when = {{"Fault", 0.0}};
  gated.sign = SignSignal{"Fault", 1.0};
  gated.unless_raw = UnlessRaw{UnlessRaw::Pattern::max, {}};
  Rig rig({bind(1, "IMU", "Yaw"), bind(2, "MIXED", "Speed"), gated}, {imu_protection()});
  MessageEncoder imu = rig.imu(imu_protection());
  std::vector<Frame> frames;
  frames.reserve(34);
  for (int i = 0; i < 30; ++i) frames.push_back(imu.frame(i));
  frames[3].data[5] ^= 1U;
  frames.push_back(raw_frame(33, IdFormat::standard, {2, 40, 0}));
  frames.push_back(raw_frame(33, IdFormat::standard, {2}));
  frames.push_back(raw_frame(416, IdFormat::extended, std::vector<std::uint8_t>(8)));
  frames.push_back(raw_frame(5, IdFormat::extended, std::vector<std::uint8_t>(8)));

  const Database database = parse_dbc(car, "car.dbc");
  const std::vector<SignalBinding> bindings{bind(1, "IMU", "Yaw")};
  std::array<Sample, max_samples_per_frame> samples;
  const std::size_t before = allocation_count();
  Decoder decoder(std::span(&database, 1), bindings, {}, {});
  EXPECT_GT(allocation_count(), before);  // the counter works
  const std::size_t after = allocation_count();
  for (const Frame& frame : frames) (void)decoder.decode(frame, samples);
  EXPECT_EQ(allocation_count(), after);
}

}  // namespace
}  // namespace odomd::can::decoder_test
