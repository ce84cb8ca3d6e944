// Encoding messages by name.
#include "can_protocol/decode/message_encoder.hpp"

#include "can_protocol/dbc/signal_layout.hpp"
#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::can::message_encoder_test {
namespace {

Message message(const char* text) {
  return parse_dbc(text, "a.dbc").messages.at(0);
}

constexpr const char* nested = R"(BO_ 2147483653 A: 12 X
 SG_ Root M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Inner m1M : 8|8@1+ (1,0) [0|0] "" X
 SG_ Deep m3 : 16|8@1- (0.5,1) [0|0] "" X
 SG_ Simple m0 : 24|8@1+ (1,0) [0|0] "" X
 SG_ Lost m : 32|8@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 5 Inner Root 2-4;
SG_MUL_VAL_ 2147483653 Inner Root 2-4;
SG_MUL_VAL_ 2147483653 Deep Inner 7-7;
SG_MUL_VAL_ 2147483653 Simple Root 0-0;
)";

TEST(MessageEncoder, EncodesItsMessage) {
  MessageEncoder encoder(message(nested));
  const Frame frame = encoder.frame(42, 3);
  constexpr std::array<std::uint8_t, max_payload> zeros{};
  EXPECT_THAT(frame, testing::FieldsAre(42, 5U, IdFormat::extended, FrameKind::data,
                                        FrameProtocol::fd, 3, 12, 0, zeros));
}

TEST(MessageEncoder, SelectsAMultiplexedSignalThroughAllItsMultiplexors) {
  MessageEncoder encoder(message(nested));
  const auto bytes = [&](std::size_t count) {
    const Frame frame = encoder.frame(0);
    return std::vector<int>(frame.data.begin(), frame.data.begin() + count);
  };
  encoder.set("Deep", -3.0);
  EXPECT_THAT(bytes(3), ElementsAre(2, 7, 0xF8));
  encoder.set("Root", 3.0);  // selects Inner as well
  encoder.set("Deep", 1.0);
  EXPECT_THAT(bytes(2), ElementsAre(3, 7));
  encoder.set("Simple", 9.0);
  EXPECT_THAT(bytes(1), ElementsAre(0));
}

TEST(MessageEncoder, RefusesValuesThatItCannotSend) {
  MessageEncoder encoder(message(nested));
  EXPECT_EQ(message_of([&] { encoder.set("Deeep", 1.0); }),
            "message 'A' has no signal 'Deeep'; the nearest is 'Deep'");
  EXPECT_THROW(encoder.set("Deep", std::nan("")), std::invalid_argument);
  EXPECT_THROW(encoder.set("Lost", 1.0), std::invalid_argument);  // no value selects it
  EXPECT_THROW(encoder.set_bits("Lost", 1), std::invalid_argument);
  EXPECT_EQ(encoder.frame(0).data, (std::array<std::uint8_t, max_payload>{}));
}

TEST(MessageEncoder, SendsProtectedFramesOfOurOwnBus) {
  const Database bus = read_dbc(ODOMD_SOURCE_DIR "/can_protocol/odomd.dbc");
  EXPECT_THAT(bus.warnings, IsEmpty());
  EXPECT_EQ(bus.messages.size(), 4U);
  for (const Message& sent : bus.messages) {
    const E2eBinding e2e{.message = sent.name,
                         .profile = E2eProfile::p01,
                         .data_id = static_cast<std::uint16_t>(sent.id),
                         .crc_signal = sent.name + "_CRC",
                         .counter_signal = sent.name + "_Counter"};
    EXPECT_GE(sent.cycle_time_ns, 5'000'000);
    EXPECT_LE(sent.cycle_time_ns, 10'000'000);
    for (const Signal& signal : sent.signals)
      EXPECT_FALSE(signal.comment.empty() && signal.unit.empty());
    MessageEncoder encoder(sent, e2e);
    const E2eProtection receiver(sent, e2e);
    E2eState state;
    for (int i = 0; i < 40; ++i) {
      for (const Signal& signal : sent.signals)
        if (!signal.unit.empty()) encoder.set(signal.name, 0.01 * i - 0.2);
      const Frame frame = encoder.frame(i);
      EXPECT_EQ(receiver.check(frame.payload(), state), E2eStatus::ok);
      for (const Signal& signal : sent.signals) {
        if (signal.unit.empty()) continue;
        const SignalLayout layout = layout_of(signal);
        EXPECT_NEAR(physical_value(layout, extract_bits(layout, frame.payload())), 0.01 * i - 0.2,
                    0.501 * signal.scale);
      }
    }
  }
}

}  // namespace
}  // namespace odomd::can::message_encoder_test
