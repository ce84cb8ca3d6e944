// Which raw values are valid: conditions, values that mean "not available", the first values of a
// source, and a sign in a separate signal. Twenty siblings of each.
#include <fmt/format.h>

#include <optional>
#include <tuple>

#include "can_protocol/decode/message_encoder.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::validity_test {
namespace {

/// A decoder for one message with one binding.
struct Rig {
  Rig(const std::string& signals, SignalBinding binding)
      : database(parse_dbc("BO_ 1 M: 16 X\n" + signals, "car.dbc")),
        encoder(database.messages.at(0)),
        decoder({&database, 1}, {&binding, 1}, {}, {}) {}

  /// The value, if it is valid.
  std::optional<double> decode(std::int64_t time_ns = 0) {
    std::array<Sample, max_samples_per_frame> samples;
    const DecodeResult result = decoder.decode(encoder.frame(time_ns), samples);
    const bool valid = result.count == 1;
    EXPECT_EQ(result.not_valid, valid ? 0U : 1U);
    EXPECT_EQ(result.verdict, valid ? FrameVerdict::decoded : FrameVerdict::no_sample);
    return valid ? std::optional(samples[0].value) : std::nullopt;
  }
  std::optional<double> decode_bits(std::uint64_t bits, std::int64_t time_ns = 0) {
    encoder.set_bits("S", bits);
    return decode(time_ns);
  }

  Database database;
  MessageEncoder encoder;
  Decoder decoder;
};

SignalBinding binding() {
  return binding_of("M", "S");
}

std::string signal(std::string_view name, int start, int length, char sign = '+',
                   double scale = 1.0) {
  return fmt::format(" SG_ {} : {}|{}@1{} ({},0) [0|0] \"\" X\n", name, start, length, sign, scale);
}

std::string refusal_of(const std::string& signals, const SignalBinding& binding) {
  return refusal(parse_dbc("BO_ 1 M: 16 X\n" + signals, "car.dbc"), {binding});
}

TEST(ValidWhen, ComparesPhysicalValuesWithoutRounding) {
  for (int i = 0; i < 20; ++i) {
    const double scale = std::array{1.0, 0.1, 0.3, 0.7, 1e-3}[static_cast<std::size_t>(i) % 5];
    const int limit = 3 + 7 * i;
    const double value = limit * scale;
    for (const int raw : {limit - 1, limit, limit + 1})
      for (const auto& [comparison, valid] : {std::pair{Comparison::equals, raw == limit},
                                              {Comparison::not_equals, raw != limit},
                                              {Comparison::below, raw < limit},
                                              {Comparison::at_least, raw >= limit}}) {
        SignalBinding one = binding();
        one.valid_when = {{"State", value, comparison}};
        Rig rig(signal("S", 0, 16) + signal("State", 16, 12, '+', scale), one);
        rig.encoder.set_bits("State", static_cast<std::uint64_t>(raw));
        EXPECT_EQ(rig.decode().has_value(), valid)
            << raw << ' ' << comparison_names.at(static_cast<std::size_t>(comparison)) << value;
      }
  }
}

TEST(ValidWhen, HoldsIfAllConditionsDo) {
  SignalBinding both = binding();
  both.valid_when = {{"A", 1.0}, {"F", 2.0, Comparison::below}};
  Rig rig(signal("S", 0, 16) + signal("A", 16, 4) + signal("F", 32, 32) + "SIG_VALTYPE_ 1 F : 1;\n",
          both);
  for (const auto& [a, f, valid] :
       {std::tuple{1U, 1.0, true}, {0U, 1.0, false}, {1U, 2.0, false}, {1U, std::nan(""), false}}) {
    rig.encoder.set_bits("A", a);
    rig.encoder.set("F", f);
    EXPECT_EQ(rig.decode().has_value(), valid) << a << ' ' << f;
  }
}

TEST(UnlessRaw, RejectsItsValuesAtAnyTime) {
  using Pattern = UnlessRaw::Pattern;
  for (int length = 2; length < 22; ++length)
    for (const char sign : {'+', '-'}) {
      SCOPED_TRACE(fmt::format("{} bits {}", length, sign));
      const std::uint64_t ones = (1ULL << static_cast<unsigned>(length)) - 1;
      const std::uint64_t max = sign == '+' ? ones : ones >> 1U;
      const std::int64_t listed = sign == '+' ? 2 : -2;
      for (const auto& [unless, bits] :
           {std::pair{UnlessRaw{Pattern::max, {}}, max},
            {UnlessRaw{Pattern::all_ones, {}}, ones},
            {UnlessRaw{Pattern::listed, {1, listed}}, static_cast<std::uint64_t>(listed) & ones}}) {
        SignalBinding unavailable = binding();
        unavailable.unless_raw = unless;
        Rig rig(signal("S", 0, length, sign), unavailable);
        EXPECT_TRUE(rig.decode_bits(0));
        EXPECT_FALSE(rig.decode_bits(bits));
        EXPECT_TRUE(rig.decode_bits(0));
      }
    }
}

TEST(UnlessRaw, RefusesValuesThatTheSignalNeverHas) {
  SignalBinding never = binding();
  never.unless_raw = UnlessRaw{UnlessRaw::Pattern::listed, {256}};
  EXPECT_THAT(refusal_of(signal("S", 0, 8), never), HasSubstr("never has the raw value 256"));
  EXPECT_EQ(refusal_of(signal("S", 0, 9), never), "");
  EXPECT_THAT(refusal_of(signal("S", 0, 9, '-'), never), HasSubstr("never has the raw value 256"));
  EXPECT_THAT(refusal_of(signal("S", 0, 32) + "SIG_VALTYPE_ 1 S : 1;\n", never),
              HasSubstr("floating-point"));
}

TEST(FirstValues, AtAnEndOfTheRangeAreRejectedUntilAnother) {
  for (int length = 8; length < 28; ++length)
    for (const char sign : {'+', '-'}) {
      SCOPED_TRACE(fmt::format("{} bits {}", length, sign));
      const std::uint64_t ones = (1ULL << static_cast<unsigned>(length)) - 1;
      std::vector<std::uint64_t> ends{ones};
      if (sign == '-') ends = {ones >> 1U, (ones >> 1U) + 1};
      for (const std::uint64_t end : ends) {
        Rig rig(signal("S", 0, length, sign), binding());
        std::int64_t time_ns = 0;
        for (const auto& [bits, after_ms, believed] : {std::tuple{end, 10, false},
                                                       {end, 10, false},
                                                       {std::uint64_t{1}, 10, true},
                                                       {end, 10, true},  // the sensor is measuring
                                                       {end, 2000, false},  // the sensor was off
                                                       {end - 2, 10, true},
                                                       {end, 10, true}}) {
          time_ns += after_ms * 1'000'000;
          EXPECT_EQ(rig.decode_bits(bits, time_ns).has_value(), believed) << bits;
        }
      }
    }
}

TEST(FirstValues, AreAcceptedIfAllOnesAreMeaningful) {
  for (int length = 1; length < 8; ++length) {
    Rig flag(signal("S", 0, length), binding());
    EXPECT_TRUE(flag.decode_bits(~std::uint64_t{0})) << length;
  }
  SignalBinding gear = binding();
  gear.forward = 255.0;
  gear.reverse = 1.0;
  EXPECT_EQ(Rig(signal("S", 0, 8), gear).decode_bits(255), 1.0);
  SignalBinding always = binding();
  always.unless_raw.emplace();
  EXPECT_TRUE(Rig(signal("S", 0, 16), always).decode_bits(0xFFFF));
  EXPECT_EQ(Rig(signal("S", 0, 16, '-'), binding()).decode_bits(0xFFFF), -1.0);
}

TEST(Sign, ComesFromAnotherSignal) {
  for (int i = 0; i < 20; ++i) {
    const double scale = 0.01 * (i + 1);
    const double negative = i % 2;
    SignalBinding turn = binding();
    turn.signals = {"S", "Fraction"};
    turn.sign = SignSignal{"Minus", negative};
    turn.unit = Unit::deg_per_s;
    turn.scale = i % 3 == 0 ? -2.0 : 1.0;
    turn.offset = 0.5;
    Rig rig(signal("S", 0, 14, '+', scale) + signal("Fraction", 14, 4, '+', 0.001) +
                signal("Minus", 20 + i, 1),
            turn);
    rig.encoder.set_bits("S", 100);
    rig.encoder.set_bits("Fraction", 3);
    const double magnitude = (100 * scale + 0.003) * std::acos(-1.0) / 180.0;
    for (const unsigned bit : {0U, 1U}) {
      rig.encoder.set_bits("Minus", bit);
      const double sign = bit == static_cast<unsigned>(negative) ? -1.0 : 1.0;
      EXPECT_NEAR(rig.decode().value(), turn.scale * sign * magnitude + 0.5, 1e-12) << i;
    }
  }
}

TEST(Sign, MustBeASignalOfTheMessage) {
  SignalBinding turn = binding();
  turn.sign = SignSignal{"Minsu", 1.0};
  EXPECT_THAT(refusal_of(signal("S", 0, 8) + signal("Minus", 8, 1), turn),
              HasSubstr("the nearest is 'Minus'"));
  turn.sign = SignSignal{"Minus", 2.0};
  EXPECT_THAT(refusal_of(signal("S", 0, 8) + signal("Minus", 8, 1), turn),
              HasSubstr("'Minus' never has the value 2"));
}

}  // namespace
}  // namespace odomd::can::validity_test
