// Messages of J1939 databases match by parameter group number, for any sender and priority.
#include <fmt/format.h>
#include <linux/can/raw.h>

#include "can_protocol/dbc/message_index.hpp"
#include "can_protocol/sources/frame_receiver.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::j1939_test {
namespace {

constexpr const char* by_frame_format =
    R"(BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_DEF_ "VFrameFormat" "J1939PG";
)";
constexpr const char* by_protocol = R"(BA_DEF_ "ProtocolType" STRING ;
BA_DEF_DEF_ "ProtocolType" "";
BA_ "ProtocolType" "J1939";
)";

constexpr std::uint32_t id_of(std::uint32_t priority, std::uint32_t pdu_format,
                              std::uint32_t pdu_specific, std::uint32_t source) {
  return priority << 26U | pdu_format << 16U | pdu_specific << 8U | source;
}

std::string message(std::string_view name, std::uint32_t id) {
  return fmt::format("BO_ {} {}: 8 X\n SG_ V : 0|16@1+ (1,0) [0|0] \"\" X\n", id | 0x8000'0000U,
                     name);
}

SignalBinding binding(std::uint16_t channel, std::string message,
                      std::optional<std::uint8_t> source = {}) {
  SignalBinding binding = binding_of(std::move(message), "V", channel);
  binding.source = source;
  return binding;
}

Frame frame(std::uint32_t id) {
  return {.id = id, .format = IdFormat::extended, .length = 8};
}

Decoder decoder_for(const Database& database, const std::vector<SignalBinding>& bindings) {
  return {{&database, 1}, bindings, {}, {}};
}

/// The channels of the samples of a frame.
std::vector<int> channels(Decoder& decoder, std::uint32_t id) {
  std::array<Sample, max_samples_per_frame> samples;
  const DecodeResult result = decoder.decode(frame(id), samples);
  std::vector<int> channels;
  for (int i = 0; i < result.count; ++i)
    channels.push_back(samples.at(static_cast<std::size_t>(i)).channel);
  return channels;
}

TEST(J1939, MatchesByGroupNumber) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    const std::uint32_t format = 170 + 4 * i;  // PDU1 below 240
    const bool pdu1 = format < 240;
    const std::uint32_t specific = 10 + 11 * i;
    const std::uint32_t id = id_of(i % 8, format, specific, 0xFE);
    SCOPED_TRACE(fmt::format("{:08X}", id));
    for (const char* attributes : {by_frame_format, by_protocol}) {
      const Database database = parse_dbc(message("M", id) + attributes, "truck.dbc");
      Decoder decoder = decoder_for(database, {binding(1, "M")});
      const MessageIndex index({&database, 1});
      const auto filters =
          exact_filters(std::vector{frame_key(id, IdFormat::extended) | j1939_group_flag});
      ASSERT_EQ(filters.size(), 1U);
      const auto taken = [&](std::uint32_t other) {
        const bool decoded = channels(decoder, other) == std::vector{1};
        EXPECT_EQ(index.find(frame(other)) != nullptr, decoded);
        EXPECT_EQ(((other | 0x8000'0000U) & filters[0].can_mask) == filters[0].can_id, decoded);
        return decoded;
      };
      EXPECT_TRUE(taken(id));
      EXPECT_TRUE(taken(id_of((i + 3) % 8, format, specific, i)));    // priority, source
      EXPECT_EQ(taken(id_of(3, format, specific ^ 1U, 0xFE)), pdu1);  // destination, or group
      EXPECT_FALSE(taken(id_of(3, format ^ 1U, specific, 0xFE)));
      EXPECT_FALSE(taken(id_of(3, format, specific, 0xFE) | 1U << 24U));  // data page
      EXPECT_FALSE(taken(id_of(3, format, specific, 0xFE) | 1U << 25U));
    }
  }
}

TEST(J1939, UsesOnlyTheConfiguredSource) {
  const Database database =
      parse_dbc(message("M", id_of(6, 254, 191, 0xFE)) + by_protocol, "truck.dbc");
  Decoder decoder = decoder_for(
      database, {binding(1, "M", std::uint8_t{0x0B}), binding(2, "M", std::uint8_t{0x21})});
  for (std::uint32_t source = 0; source < 256; ++source)
    EXPECT_EQ(channels(decoder, id_of(3, 254, 191, source)), source == 0x0B   ? std::vector{1}
                                                             : source == 0x21 ? std::vector{2}
                                                                              : std::vector<int>{})
        << source;
  EXPECT_EQ(decoder.counters(0).verdicts[static_cast<std::size_t>(FrameVerdict::decoded)].get(),
            2U);
}

TEST(J1939, DistinguishesMessagesOfAGroupByAddress) {
  const Database database = parse_dbc(
      message("A", id_of(3, 240, 4, 0)) + message("B", id_of(3, 240, 4, 1)) + by_frame_format,
      "truck.dbc");
  Decoder decoder = decoder_for(database, {binding(1, "A"), binding(2, "B")});
  EXPECT_EQ(channels(decoder, id_of(6, 240, 4, 0)), std::vector{1});
  EXPECT_EQ(channels(decoder, id_of(6, 240, 4, 1)), std::vector{2});
  EXPECT_EQ(channels(decoder, id_of(6, 240, 4, 2)), std::vector<int>{});
  EXPECT_EQ(refusal(database, {binding(1, "A", std::uint8_t{0})}), "");
  EXPECT_THAT(refusal(database, {binding(1, "A", std::uint8_t{5})}),
              HasSubstr("has one identifier only"));
}

TEST(J1939, IsNotAssumedOfOtherDatabases) {
  const std::uint32_t id = id_of(6, 254, 191, 0x0B);
  const std::string one = fmt::format("BA_ \"VFrameFormat\" BO_ {} 1;\n", id | 0x8000'0000U);
  for (const std::string& attributes :
       {std::string(), by_frame_format + one, by_frame_format + std::string(by_protocol) + one}) {
    const Database database = parse_dbc(message("M", id) + attributes, "car.dbc");
    Decoder decoder = decoder_for(database, {binding(1, "M")});
    EXPECT_EQ(channels(decoder, id), std::vector{1});
    EXPECT_EQ(channels(decoder, id ^ 1U), std::vector<int>{});
    EXPECT_THAT(refusal(database, {binding(1, "M", std::uint8_t{0x0B})}), HasSubstr("car.dbc:1"));
  }
}

TEST(J1939, GroupsOfTwoDatabasesNeedDifferentSources) {
  const std::vector<Database> databases{
      parse_dbc(message("A", id_of(3, 254, 7, 0)) + by_protocol, "a.dbc"),
      parse_dbc(message("B", id_of(3, 254, 7, 9)) + by_protocol, "b.dbc")};
  const auto decoder = [&](std::optional<std::uint8_t> a, std::optional<std::uint8_t> b) {
    return Decoder(databases, std::vector{binding(1, "A", a), binding(2, "B", b)}, {}, {});
  };
  EXPECT_THROW((void)decoder({}, {}), std::invalid_argument);
  EXPECT_THROW((void)decoder(std::uint8_t{1}, {}), std::invalid_argument);
  Decoder both = decoder(std::uint8_t{1}, std::uint8_t{2});
  EXPECT_EQ(channels(both, id_of(3, 254, 7, 1)), std::vector{1});
  EXPECT_EQ(channels(both, id_of(3, 254, 7, 2)), std::vector{2});
}

}  // namespace
}  // namespace odomd::can::j1939_test
