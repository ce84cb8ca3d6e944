// The decoder: it compiles bindings, gives verdicts and values of frames, and never allocates while
// decoding.
#include "can_protocol/decode/decoder.hpp"

#include <numbers>
#include <tuple>

#include "can_protocol/decode/e2e_trust.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "can_protocol/decode/units.hpp"
#include "tests/allocation_count.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::decoder_test {
namespace {

using testing::DoubleEq;

constexpr const char* car = R"(BO_ 416 IMU: 8 X
 SG_ CRC : 0|8@1+ (1,0) [0|0] "" X
 SG_ Counter : 8|4@1+ (1,0) [0|0] "" X
 SG_ Yaw : 16|16@1- (0.01,0) [0|0] "deg/s" X
 SG_ Acc : 32|16@1- (0.001,0) [0|0] "g" X
BO_ 2147484064 WHEELS: 8 X
 SG_ Left : 0|16@1+ (0.1,0) [0|0] "km/h" X
 SG_ Right : 16|16@1+ (0.1,0) [0|0] "km/h" X
 SG_ Fault : 32|2@1+ (1,0) [0|0] "" X
 SG_ Motor : 48|16@1- (1,0) [0|0] "rpm" X
BO_ 32 STEER: 4 X
 SG_ Angle : 7|12@0- (1.5,0) [0|0] "deg" X
 SG_ Fraction : 11|4@0- (0.1,0) [0|0] "deg" X
 SG_ Gear : 16|3@1+ (1,0) [0|0] "" X
BO_ 33 MIXED: 3 X
 SG_ Page M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Speed m2 : 8|8@1+ (0.5,-10) [0|0] "m/s" X
 SG_ Other m3 : 8|16@1+ (1,0) [0|0] "" X
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_ "GenMsgCycleTime" BO_ 416 5;
)";

SignalBinding bind(std::uint16_t channel, std::string message, std::string signal,
                   Unit unit = Unit::none) {
  SignalBinding binding = binding_of(std::move(message), std::move(signal), channel);
  binding.unit = unit;
  return binding;
}

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
    return result.verdict;
  }

  [[nodiscard]] Values values() const {
    Values values;
    for (const Sample& sample : samples_) values.emplace_back(sample.channel, sample.value);
    return values;
  }
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] const Decoder& decoder() const { return decoder_; }

  [[nodiscard]] MessageEncoder encoder(std::string_view message) const {
    return MessageEncoder(*find_message(databases_[0], message));
  }
  [[nodiscard]] MessageEncoder encoder(std::string_view message, const E2eBinding& e2e) const {
    return {*find_message(databases_[0], message), e2e};
  }

 private:
  std::vector<Database> databases_;
  Decoder decoder_;
  std::vector<Sample> samples_;
};

Frame raw_frame(std::uint32_t id, IdFormat format, std::vector<std::uint8_t> payload) {
  Frame frame;
  frame.time_ns = 1'000;
  frame.id = id;
  frame.format = format;
  frame.length = static_cast<std::uint8_t>(payload.size());
  std::copy(payload.begin(), payload.end(), frame.data.begin());
  return frame;
}

TEST(Decoder, ConvertsUnitsThenScaleThenOffset) {
  SignalBinding yaw = bind(1, "IMU", "Yaw", Unit::deg_per_s);
  yaw.scale = -2.0;
  yaw.offset = 0.25;
  yaw.latency_ns = 300;
  SignalBinding motor = bind(4, "WHEELS", "Motor", Unit::rpm);
  motor.radius_m = 0.05;
  motor.ratio = 8.0;
  Rig rig({yaw, bind(2, "IMU", "Acc", Unit::g), bind(3, "WHEELS", "Left", Unit::km_per_h), motor});

  MessageEncoder imu = rig.encoder("IMU");
  imu.set("Yaw", 90.0);
  imu.set("Acc", -0.5);
  EXPECT_EQ(rig.decode(imu.frame(10'000)), FrameVerdict::decoded);
  EXPECT_THAT(rig.values(), ElementsAre(Pair(1, DoubleEq(-std::numbers::pi + 0.25)),
                                        Pair(2, DoubleEq(-0.5 * 9.80665))));
  EXPECT_EQ(rig.samples()[0].time_ns, 9'700);
  EXPECT_EQ(rig.samples()[1].time_ns, 10'000);

  MessageEncoder wheels = rig.encoder("WHEELS");
  wheels.set("Left", 36.0);
  wheels.set("Motor", -4800.0);
  EXPECT_EQ(rig.decode(wheels.frame(0)), FrameVerdict::decoded);
  // 600 wheel turns per minute are 10 per second: 10 * 2 pi * 0.05 m.
  EXPECT_THAT(rig.values(),
              ElementsAre(Pair(3, DoubleEq(10.0)), Pair(4, DoubleEq(-std::numbers::pi))));
}

TEST(Decoder, TurnsRotationsOfAWheelIntoItsSpeed) {
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

TEST(Decoder, SumsSignals) {
  SignalBinding steering = bind(1, "STEER", "Angle", Unit::deg);
  steering.signals = {"Angle", "Fraction"};
  Rig rig({steering});
  MessageEncoder steer = rig.encoder("STEER");
  steer.set("Angle", -30.0);
  steer.set("Fraction", 0.7);
  EXPECT_EQ(rig.decode(steer.frame(0)), FrameVerdict::decoded);
  ASSERT_EQ(rig.samples().size(), 1U);
  EXPECT_NEAR(rig.samples()[0].value, -29.3 * std::numbers::pi / 180.0, 1e-12);
}

TEST(Decoder, CountsASampleOnlyWhileItIsValid) {
  SignalBinding left = bind(1, "WHEELS", "Left", Unit::km_per_h);
  left.valid_when = {{"Fault", 2.0}};
  Rig rig({left, bind(2, "WHEELS", "Right", Unit::km_per_h)});
  MessageEncoder wheels = rig.encoder("WHEELS");
  EXPECT_EQ(rig.decode(wheels.frame(0)), FrameVerdict::decoded);
  EXPECT_THAT(rig.values(), ElementsAre(Pair(2, 0.0)));
  wheels.set("Fault", 2.0);
  EXPECT_EQ(rig.decode(wheels.frame(0)), FrameVerdict::decoded);
  EXPECT_THAT(rig.values(), ElementsAre(Pair(1, 0.0), Pair(2, 0.0)));
}

TEST(Decoder, MakesADirectionOfItsValues) {
  SignalBinding gear = bind(1, "STEER", "Gear");
  gear.forward = 1.0;
  gear.reverse = 2.0;
  gear.scale = 100.0;  // does not apply to gears
  Rig rig({gear});
  MessageEncoder steer = rig.encoder("STEER");
  for (const auto& [raw, direction] : Values{{1, 1.0}, {2, -1.0}, {0, 0.0}, {7, 0.0}}) {
    steer.set_bits("Gear", static_cast<std::uint64_t>(raw));
    EXPECT_EQ(rig.decode(steer.frame(0)), FrameVerdict::decoded);
    EXPECT_THAT(rig.values(), ElementsAre(Pair(1, direction)));
  }
}

TEST(Decoder, SeesMultiplexedSignalsOnlyWhenTheyArePresent) {
  Rig rig({bind(1, "MIXED", "Speed", Unit::m_per_s)});
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {2, 40, 0})), FrameVerdict::decoded);
  EXPECT_THAT(rig.values(), ElementsAre(Pair(1, 10.0)));
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {3, 40, 0})), FrameVerdict::no_sample);
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {2})), FrameVerdict::too_short);
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {3})), FrameVerdict::no_sample);
  EXPECT_EQ(rig.decode(raw_frame(33, IdFormat::standard, {})), FrameVerdict::too_short);
}

TEST(Decoder, TakesNothingOfAPayloadThatEndsBeforeABoundSignal) {
  Rig rig({bind(1, "WHEELS", "Left"), bind(2, "WHEELS", "Right")});
  const Frame whole = raw_frame(416, IdFormat::extended, {1, 0, 2, 0});
  EXPECT_EQ(rig.decode(whole), FrameVerdict::decoded);  // unbound signals may be missing
  EXPECT_EQ(rig.decode(raw_frame(416, IdFormat::extended, {1, 0, 2})), FrameVerdict::too_short);
  EXPECT_TRUE(rig.samples().empty());
  Frame longer = whole;
  longer.length = 64;
  EXPECT_EQ(rig.decode(longer), FrameVerdict::decoded);
  longer.length = 255;  // longer than any frame: the decoder must not read beyond the end
  EXPECT_EQ(rig.decode(longer), FrameVerdict::decoded);
}

TEST(Decoder, DistinguishesIdentifiersOfBothFormats) {
  Rig rig({bind(1, "IMU", "Yaw"), bind(2, "WHEELS", "Left")});
  const std::vector<std::uint8_t> zeros(8);
  EXPECT_EQ(rig.decode(raw_frame(416, IdFormat::standard, zeros)), FrameVerdict::decoded);
  EXPECT_THAT(rig.values(), ElementsAre(Pair(1, 0.0)));
  EXPECT_EQ(rig.decode(raw_frame(416, IdFormat::extended, zeros)), FrameVerdict::decoded);
  EXPECT_THAT(rig.values(), ElementsAre(Pair(2, 0.0)));
  for (const std::uint32_t id : {0U, 415U, 417U, 2047U, 2048U, 0xFFFF'FFFFU}) {
    EXPECT_EQ(rig.decode(raw_frame(id, IdFormat::standard, zeros)), FrameVerdict::unmapped);
    EXPECT_EQ(rig.decode(raw_frame(id, IdFormat::extended, zeros)), FrameVerdict::unmapped);
  }
}

TEST(Decoder, PassesOverRemoteAndErrorFrames) {
  Rig rig({bind(1, "IMU", "Yaw")});
  Frame frame = raw_frame(416, IdFormat::standard, std::vector<std::uint8_t>(8));
  frame.kind = FrameKind::remote;
  EXPECT_EQ(rig.decode(frame), FrameVerdict::unmapped);
  frame.kind = FrameKind::error;
  EXPECT_EQ(rig.decode(frame), FrameVerdict::unmapped);
  frame.kind = FrameKind::data;
  frame.bus = 200;
  EXPECT_EQ(rig.decode(frame), FrameVerdict::unmapped);
}

TEST(Decoder, TakesABindingFromItsBusOnly) {
  SignalBinding left = bind(1, "WHEELS", "Left");
  left.bus = "can1";
  Rig rig({left});
  Frame frame = raw_frame(416, IdFormat::extended, std::vector<std::uint8_t>(8));
  EXPECT_EQ(rig.decode(frame), FrameVerdict::unmapped);
  frame.bus = 1;
  EXPECT_EQ(rig.decode(frame), FrameVerdict::decoded);
}

TEST(Decoder, LetsTwoMessagesShareAnIdentifierOnDifferentBuses) {
  const std::vector<Database> databases{
      parse_dbc("BO_ 7 A: 1 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n", "a.dbc"),
      parse_dbc("BO_ 7 B: 1 X\n SG_ S : 0|8@1+ (2,0) [0|0] \"\" X\n", "b.dbc")};
  std::vector<SignalBinding> bindings{bind(1, "A", "S"), bind(2, "B", "S")};
  const std::vector<std::string> buses{"can0", "can1"};
  EXPECT_THROW(Decoder(databases, bindings, {}, buses), std::invalid_argument);
  bindings[0].bus = "can0";
  bindings[1].bus = "can1";
  Decoder decoder(databases, bindings, {}, buses);
  std::array<Sample, max_samples_per_frame> samples;
  Frame frame = raw_frame(7, IdFormat::standard, {5});
  EXPECT_EQ(decoder.decode(frame, samples).verdict, FrameVerdict::decoded);
  EXPECT_EQ(samples[0].channel, 1);
  frame.bus = 1;
  EXPECT_EQ(decoder.decode(frame, samples).verdict, FrameVerdict::decoded);
  EXPECT_EQ(samples[0].channel, 2);
  EXPECT_EQ(samples[0].value, 10.0);
}

TEST(Decoder, TakesAMessageFromTheFirstDatabaseThatHasIt) {
  const std::vector<Database> databases{
      parse_dbc("BO_ 7 A: 1 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n", "a.dbc"),
      parse_dbc("BO_ 8 A: 1 X\n SG_ T : 0|8@1+ (2,0) [0|0] \"\" X\n", "b.dbc")};
  const std::vector<SignalBinding> bindings{bind(1, "A", "S")};
  const Decoder decoder(databases, bindings, {}, {});
  EXPECT_EQ(decoder.messages()[0].id, 7U);
}

TEST(Decoder, ListsItsMessages) {
  const Rig rig({bind(5, "IMU", "Yaw"), bind(6, "WHEELS", "Left"), bind(7, "IMU", "Acc")});
  const auto messages = rig.decoder().messages();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].name, "IMU");
  EXPECT_EQ(messages[0].cycle_time_ns, 5'000'000);
  EXPECT_THAT(messages[0].channels, ElementsAre(5, 7));
  EXPECT_EQ(messages[1].format, IdFormat::extended);
  EXPECT_EQ(messages[1].id, 416U);
  EXPECT_EQ(messages[1].cycle_time_ns, 0);
}

// Protection --------------------------------------------------------------------------------------

E2eBinding imu_protection() {
  E2eBinding e2e;
  e2e.message = "IMU";
  e2e.profile = E2eProfile::p01;
  e2e.data_id = 0x1A0;
  e2e.crc_signal = "CRC";
  e2e.counter_signal = "Counter";
  return e2e;
}

TEST(Decoder, GivesEveryProtectedFrameItsVerdictAndCountsIt) {
  Rig rig({bind(1, "IMU", "Yaw")}, {imu_protection()});
  MessageEncoder imu = rig.encoder("IMU", imu_protection());
  const Frame first = imu.frame(100);
  EXPECT_EQ(rig.decode(first), FrameVerdict::decoded);
  EXPECT_EQ(rig.decode(first), FrameVerdict::repeated);
  EXPECT_TRUE(rig.samples().empty());
  Frame broken = imu.frame(200);
  broken.data[4] ^= 1U;
  EXPECT_EQ(rig.decode(broken), FrameVerdict::failed_crc);
  EXPECT_TRUE(rig.samples().empty());
  EXPECT_EQ(rig.decode(imu.frame(250)), FrameVerdict::distrusted);  // right after an error
  EXPECT_TRUE(rig.samples().empty());
  (void)imu.frame(0);
  EXPECT_EQ(rig.decode(imu.frame(300)), FrameVerdict::decoded);  // one frame was lost: OKSOMELOST
  for (int i = 0; i < 5; ++i) (void)imu.frame(0);
  EXPECT_EQ(rig.decode(imu.frame(400)), FrameVerdict::wrong_sequence);
  EXPECT_TRUE(rig.samples().empty());
  EXPECT_EQ(rig.decode(imu.frame(500)), FrameVerdict::decoded);
  Frame cut = imu.frame(600);
  cut.length = 7;
  EXPECT_EQ(rig.decode(cut), FrameVerdict::too_short);

  const MessageCounters& counters = rig.decoder().counters(0);
  const auto count = [&](FrameVerdict verdict) {
    return counters.verdicts[static_cast<std::size_t>(verdict)].get();
  };
  EXPECT_EQ(count(FrameVerdict::decoded), 3U);
  EXPECT_EQ(count(FrameVerdict::repeated), 1U);
  EXPECT_EQ(count(FrameVerdict::failed_crc), 1U);
  EXPECT_EQ(count(FrameVerdict::distrusted), 1U);
  EXPECT_EQ(count(FrameVerdict::wrong_sequence), 1U);
  EXPECT_EQ(count(FrameVerdict::too_short), 1U);
  EXPECT_EQ(counters.some_lost.get(), 1U);
  EXPECT_EQ(counters.last_time_ns.get(), 500U);
}

TEST(Decoder, BelievesNothingOfAMessageWhoseChecksKeepFailing) {
  Rig rig({bind(1, "IMU", "Yaw")}, {imu_protection()});
  MessageEncoder imu = rig.encoder("IMU", imu_protection());
  const auto broken = [&] {
    Frame frame = imu.frame(1);
    frame.data[4] ^= 1U;
    return frame;
  };
  for (int i = 0; i < 20; ++i) EXPECT_EQ(rig.decode(imu.frame(1)), FrameVerdict::decoded);

  // After a few failures the message is trusted from the second good frame on; after many, only
  // later.
  for (int i = 0; i < E2eTrust::max_failed / 2; ++i)
    EXPECT_EQ(rig.decode(broken()), FrameVerdict::failed_crc);
  EXPECT_EQ(rig.decode(imu.frame(1)), FrameVerdict::distrusted);
  EXPECT_TRUE(rig.samples().empty());
  EXPECT_EQ(rig.decode(imu.frame(1)), FrameVerdict::decoded);
  for (int i = 0; i < E2eTrust::window; ++i)
    EXPECT_EQ(rig.decode(broken()), FrameVerdict::failed_crc);
  (void)rig.decode(imu.frame(1));  // resumes the sequence
  EXPECT_EQ(rig.decode(imu.frame(1)), FrameVerdict::distrusted);
  EXPECT_TRUE(rig.samples().empty());

  // After the disturbance, the message is trusted once the window has moved past it.
  int refused = 0;
  while (rig.decode(imu.frame(1)) == FrameVerdict::distrusted) ++refused;
  EXPECT_LE(refused, E2eTrust::window - E2eTrust::max_failed);
  EXPECT_EQ(rig.decode(imu.frame(1)), FrameVerdict::decoded);
}

TEST(E2eTrust, IsNotShakenByAGatewayThatRepeatsEveryFrame) {
  E2eTrust trust;
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(trust.after(E2eStatus::ok));
    EXPECT_TRUE(trust.after(E2eStatus::repeated));
  }
}

TEST(Decoder, KeepsTheCountersOfTwoBusesApart) {
  Rig rig({bind(1, "IMU", "Yaw")}, {imu_protection()});
  MessageEncoder imu = rig.encoder("IMU", imu_protection());
  for (int i = 0; i < 20; ++i) {
    Frame frame = imu.frame(i);
    EXPECT_EQ(rig.decode(frame), FrameVerdict::decoded);
    frame.bus = 1;
    EXPECT_EQ(rig.decode(frame), FrameVerdict::decoded);
  }
}

TEST(Decoder, NeverFindsASignalThatNoMultiplexorValueSelects) {
  const std::vector<Database> databases{
      parse_dbc("BO_ 1 A: 8 X\n SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" X\n"
                " SG_ Lost m : 8|8@1+ (1,0) [0|0] \"\" X\n",
                "car.dbc")};
  Decoder decoder(databases, std::vector{bind(1, "A", "Lost")}, {}, {});
  std::array<Sample, max_samples_per_frame> samples;
  for (const std::uint8_t page : std::vector<std::uint8_t>{0, 1, 255})
    EXPECT_EQ(decoder.decode(raw_frame(1, IdFormat::standard, {page, 7}), samples).verdict,
              FrameVerdict::no_sample);
}

TEST(Decoder, TakesLongAndShortNamesForTheSameMessage) {
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
  MessageEncoder imu = rig.encoder("IMU", imu_protection());
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

// Mismatches ------------------------------------------------------------------------------------

TEST(DecoderErrors, NameTheRoleTheNearestNameAndTheFix) {
  using Binding = SignalBinding;
  struct {
    void (*change)(SignalBinding&, E2eBinding&);
    std::string error;
  } const cases[]{
      {[](Binding& b, E2eBinding&) { b.message = "IUM"; },
       "signal 'role_1': no message 'IUM' in car.dbc; the nearest is 'IMU'\n"},
      {[](Binding& b, E2eBinding&) { b.signals = {"yaw"}; },
       "signal 'role_1': message 'IMU' of car.dbc has no signal 'yaw'; the nearest is 'Yaw'\n"},
      {[](Binding& b, E2eBinding&) { b.bus = "can2"; },
       "signal 'role_1': there is no bus 'can2'; the nearest is 'can0'\n"},
      {[](Binding& b, E2eBinding&) {
         b.valid_when = {{"Acx", 0.0}};
       },
       "signal 'role_1': message 'IMU' of car.dbc has no signal 'Acx'; the nearest is 'Acc'\n"},
      {[](Binding&, E2eBinding& e) { e.message = "IMUU"; },
       "end-to-end protection: no message 'IMUU' in car.dbc; the nearest is 'IMU'\n"},
      {[](Binding&, E2eBinding& e) { e.crc_signal = "CRK"; }, "nearest is 'CRC'"},
      {[](Binding& b, E2eBinding&) { b.unit = Unit::rad_per_s; },
       "signal 'role_1': unit 'rad/s' contradicts 'deg/s' of signal 'IMU.Yaw' in car.dbc:4; fix "
       "one of them\n"},
      // an empty unit is no contradiction
      {[](Binding& b, E2eBinding&) { b.signals = {"Counter"}, b.unit = Unit::rad; }, "taken\n"},
      {[](Binding& b, E2eBinding&) {
         b.valid_when = {{"Counter", 16.0}};
       },
       "signal 'Counter' never has the value 16; the nearest is 15"},
      {[](Binding& b, E2eBinding&) { b.forward = 0.005; },
       "signal 'Yaw' never has the value 0.005"},
      {[](Binding& b, E2eBinding&) { b.forward = 1e-7; },
       "never has the value 1e-07; the nearest is 0"},
      // 35 * 0.01 is 0.35000000000000003
      {[](Binding& b, E2eBinding&) { b.forward = 0.354; }, "the nearest is 0.35\n"},
      {[](Binding& b, E2eBinding&) { b.forward = b.reverse = 1.0; },
       "forward and reverse are the same value"},
      {[](Binding& b, E2eBinding&) { b.signals.clear(); }, "no signal is named"},
      {[](Binding& b, E2eBinding&) {
         b.forward = 1.0, b.signals = {"CRC", "Counter"};
       },
       "a direction comes from one signal"},
      {[](Binding& b, E2eBinding&) { b.signals = {"CRC"}, b.unit = Unit::rpm; },
       "unit rpm needs the wheel's radius"},
      {[](Binding& b, E2eBinding&) {
         b.signals = {"CRC"}, b.unit = Unit::rpm, b.radius_m = 0.1, b.ratio = 0.0;
       },
       "ratio must be a number other than 0"},
      {[](Binding& b, E2eBinding&) { b.scale = HUGE_VAL; }, "not a finite"},
  };
  for (const auto& [change, error] : cases) {
    SignalBinding binding = bind(1, "IMU", "Yaw", Unit::deg_per_s);
    E2eBinding e2e = imu_protection();
    change(binding, e2e);
    const std::string refusal = message_of([&] { const Rig rig({binding}, {e2e}); });
    EXPECT_THAT((refusal.empty() ? "taken" : refusal) + '\n', HasSubstr(error));
  }
}

TEST(DecoderErrors, ReportUnitsAndFactorsThatNoValueComesOutOf) {
  const auto refusal_of = [](const std::string& scaling) {
    return can::refusal(parse_dbc("BO_ 1 W: 8 X\n SG_ V : 0|16@1+ " + scaling + " X\n", "car.dbc"),
                        {bind(1, "W", "V", Unit::m_per_s)});
  };
  EXPECT_EQ(refusal_of("(0.01,0) [0|0] \"mph\""),
            "signal 'role_1': unit 'm/s' contradicts 'mph' of signal 'W.V' in car.dbc:2; "
            "fix one of them, or use unit = \"1\" with a scale");
  EXPECT_EQ(refusal_of("(0,0) [0|0] \"m/s\""),
            "signal 'role_1': signal 'V' has the factor 0 in car.dbc:2 and never changes; "
            "fix the database");
  EXPECT_EQ(refusal_of("(0.01,0) [0|0] \"SED\""), "");
}

TEST(DecoderErrors, ReportIncompleteBindings) {
  EXPECT_THROW(Rig({}, {imu_protection(), imu_protection()}), std::invalid_argument);
  EXPECT_THROW(Decoder({}, std::vector{bind(1, "IMU", "Yaw")}, {}, {}), std::invalid_argument);
  EXPECT_THROW(Rig(std::vector(max_samples_per_frame + 1, bind(1, "IMU", "Yaw"))),
               std::invalid_argument);
}

}  // namespace
}  // namespace odomd::can::decoder_test
