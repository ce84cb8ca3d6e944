// Six databases of real cars, compared with an independent decoder: the layouts, and all payloads
// that it decoded.
#include <nlohmann/json.hpp>
#include <set>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "tests/gtest.hpp"
#include "tests/recorded_drives.hpp"

namespace odomd::can::real_databases_test {
namespace {

using nlohmann::json;

constexpr std::array names{"ESR", "ford_lincoln_base_pt",    "gm_global_a_object",
                           "mg",  "hyundai_canfd_generated", "vw_mqb"};

struct RealDatabase {
  Database database;
  json expected;
};

RealDatabase load(const std::string& name) {
  const auto folder = recorded::folder("dbc");
  return {read_dbc(folder / (name + ".dbc")),
          json::parse(recorded::text_of(folder / (name + ".json")))};
}

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

const Message* find(const Database& database, const json& message) {
  const auto format = message["ext"].get<bool>() ? IdFormat::extended : IdFormat::standard;
  for (const Message& candidate : database.messages)
    if (candidate.id == message["id"].get<std::uint32_t>() && candidate.format == format)
      return &candidate;
  return nullptr;
}

// The other decoder read all files as Windows-1252, even those in UTF-8: compare ASCII only.
bool is_ascii(const std::string& text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

void expect_same_layout(const Message& message, const Signal& signal, const json& expected) {
  SCOPED_TRACE(message.name + '.' + signal.name);
  EXPECT_EQ(signal.start_bit, expected["start"]);
  EXPECT_EQ(signal.length, expected["length"]);
  EXPECT_EQ(signal.byte_order == ByteOrder::big_endian, expected["byte_order"] == "big_endian");
  EXPECT_EQ(signal.type == ValueType::signed_integer, expected["signed"].get<bool>());
  EXPECT_EQ(signal.type == ValueType::float32 || signal.type == ValueType::float64,
            expected["float"].get<bool>());
  EXPECT_EQ(signal.scale, expected["scale"]);
  EXPECT_EQ(signal.offset, expected["offset"]);
  EXPECT_EQ(signal.minimum, expected["min"].is_null() ? 0.0 : expected["min"].get<double>());
  EXPECT_EQ(signal.maximum, expected["max"].is_null() ? 0.0 : expected["max"].get<double>());
  if (is_ascii(signal.unit)) {
    EXPECT_EQ(signal.unit, expected["unit"].is_null() ? "" : expected["unit"].get<std::string>());
  }
  EXPECT_EQ(signal.is_multiplexor, expected["is_mux"].get<bool>());
  EXPECT_EQ(signal.multiplexor.has_value(), !expected["mux_ids"].is_null());
  if (signal.multiplexor) {
    EXPECT_EQ(message.signals[*signal.multiplexor].name, expected["mux_signal"]);
    std::set<std::uint64_t> ids;
    for (const MultiplexRange& range : signal.selected_by)
      for (std::uint64_t id = range.first; id <= range.last; ++id) ids.insert(id);
    EXPECT_EQ(ids, expected["mux_ids"].get<std::set<std::uint64_t>>());
  }
  EXPECT_EQ(signal.values.size(), expected["choices"].size());
  for (const ValueName& value : signal.values) {
    ASSERT_TRUE(expected["choices"].contains(std::to_string(value.raw)));
    if (is_ascii(value.name)) {
      EXPECT_EQ(value.name, expected["choices"][std::to_string(value.raw)]);
    }
  }
}

TEST(RealDatabases, HaveTheLayoutsThatAnIndependentReaderFinds) {
  if (!recorded::at_hand(names.size())) return;
  for (const char* name : names) {
    SCOPED_TRACE(name);
    const auto [database, expected] = load(name);
    EXPECT_EQ(database.messages.size(), expected["messages"].size());
    for (const json& expected_message : expected["messages"]) {
      const Message* message = find(database, expected_message);
      ASSERT_NE(message, nullptr) << expected_message["name"];
      EXPECT_EQ(message->name, expected_message["name"]);
      EXPECT_EQ(message->length, expected_message["len"]);
      EXPECT_EQ(message->protocol == FrameProtocol::fd,
                expected_message["fd"].get<bool>() || message->length > 8);
      EXPECT_EQ(message->signals.size(), expected_message["signals"].size());
      for (const json& signal : expected_message["signals"]) {
        const Signal* found = find_signal(*message, signal["name"].get<std::string>());
        ASSERT_NE(found, nullptr) << signal["name"];
        expect_same_layout(*message, *found, signal);
      }
    }
  }
}

/// Calls visit(message, the other decoder's vector, payload).
template <typename Visit>
void each_payload(const Visit& visit) {
  for (const char* name : names) {
    SCOPED_TRACE(name);
    const auto [database, expected] = load(name);
    for (const json& expected_message : expected["messages"]) {
      const Message* message = find(database, expected_message);
      ASSERT_NE(message, nullptr);
      for (const json& vector : expected_message["vectors"])
        visit(*message, vector, bytes_of(vector["data"].get<std::string>()));
    }
  }
}

TEST(RealDatabases, DecodeAllPayloadsExactly) {
  if (!recorded::at_hand(names.size())) return;
  int values = 0;
  int payloads = 0;
  each_payload([&](const Message& message, const json& vector, const auto& payload) {
    ASSERT_EQ(payload.size(), message.length);
    if (!vector.contains("raw")) return;  // the other decoder failed
    ++payloads;
    std::size_t present = 0;
    for (const Signal& signal : message.signals) {
      if (!is_present(message, signal, payload)) continue;
      ++present;
      SCOPED_TRACE(message.name + '.' + signal.name + ' ' + vector["data"].dump());
      ASSERT_TRUE(vector["raw"].contains(signal.name));
      const json& raw = vector["raw"][signal.name];
      const SignalLayout layout = layout_of(signal);
      const std::uint64_t bits = extract_bits(layout, payload);
      if (signal.type == ValueType::signed_integer)
        EXPECT_EQ(sign_extended(bits, signal.length), raw.get<std::int64_t>());
      else
        EXPECT_EQ(bits, raw.get<std::uint64_t>());
      EXPECT_EQ(physical_value(layout, bits), vector["phys"][signal.name].get<double>());
      ++values;
    }
    EXPECT_EQ(present, vector["raw"].size());
  });
  std::printf("decoded %d values of %d payloads\n", values, payloads);
  EXPECT_GT(values, 40'000);
}

TEST(RealDatabases, EncodeBackToThePayloadsTheyDecode) {
  if (!recorded::at_hand(names.size())) return;
  int values = 0;
  each_payload([&](const Message& message, const json& vector, const auto& payload) {
    MessageEncoder encoder(message);
    std::vector<std::uint8_t> covered(payload.size());
    for (const Signal& signal : message.signals) {
      if (!is_present(message, signal, payload)) continue;
      const SignalLayout layout = layout_of(signal);
      const std::uint64_t bits = extract_bits(layout, payload);
      if (signal.length <= 53)
        encoder.set(signal.name, physical_value(layout, bits));
      else  // a double has too few bits
        encoder.set_bits(signal.name, bits);
      insert_bits(layout, ~std::uint64_t{0}, covered);
      ++values;
    }
    const Frame frame = encoder.frame(0);
    ASSERT_EQ(frame.length, payload.size());
    for (std::size_t i = 0; i < payload.size(); ++i)
      ASSERT_EQ(frame.data[i], payload[i] & covered[i])
          << message.name << ' ' << vector["data"] << " byte " << i;
  });
  EXPECT_GT(values, 40'000);
}

}  // namespace
}  // namespace odomd::can::real_databases_test
