// Six databases of real cars, compared with an independent decoder: the layouts, and all payloads
// that it decoded.
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
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
    EXPECT_EQ(message.signals[*signal.multiplexor].name, expected["mux_signal"].get<std::string>());
    std::set<std::uint64_t> ids;
    for (const MultiplexRange& range : signal.selected_by)
      for (std::uint64_t id = range.first; id <= range.last; ++id) ids.insert(id);
    EXPECT_EQ(ids, expected["mux_ids"].get<std::set<std::uint64_t>>());
  }
  EXPECT_EQ(signal.values.size(), expected["choices"].size());
  for (const ValueName& value : signal.values) {
    ASSERT_TRUE(expected["choices"].contains(std::to_string(value.raw)));
    if (is_ascii(value.name)) {
      EXPECT_EQ(value.name, expected["choices"][std::to_string(value.raw)].get<std::string>());
    }
  }
}

TEST(RealDatabases, HaveTheLayoutsOfAnIndependentReader) {
  if (!recorded::at_hand(names.size())) return;
  for (const char* name : names) {
    SCOPED_TRACE(name);
    const auto [database, expected] = load(name);
    EXPECT_EQ(database.messages.size(), expected["messages"].size());
    for (const json& expected_message : expected["messages"]) {
      const Message* message = find(database, expected_message);
      ASSERT_NE(message, nullptr) << expected_message["name"];
      EXPECT_EQ(message->name, expected_message["name"].get<std::string>());
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

/// A frame in which only the signals of the payload are set, from their physical values.
Frame encoded_again(const Message& message, const std::vector<std::uint8_t>& payload) {
  MessageEncoder encoder(message);
  for (const Signal& signal : message.signals) {
    if (!is_present(message, signal, payload)) continue;
    const SignalLayout layout = layout_of(signal);
    const std::uint64_t bits = extract_bits(layout, payload);
    if (signal.length <= 53)
      encoder.set(signal.name, physical_value(layout, bits));
    else  // a double has too few bits
      encoder.set_bits(signal.name, bits);
  }
  return encoder.frame(0);
}

/// Binds the message's signals, up to the limit of a frame. Their first values are accepted.
std::vector<SignalBinding> bindings_of(const Message& message) {
  std::vector<SignalBinding> bindings;
  for (const Signal& signal : message.signals) {
    if (bindings.size() == max_samples_per_frame) break;
    bindings.push_back(
        binding_of(message.name, signal.name, static_cast<std::uint16_t>(bindings.size())));
    bindings.back().unless_raw.emplace();
  }
  return bindings;
}

TEST(RealDatabases, DecodeAllPayloadsExactlyAndEncodeThemAgain) {
  if (!recorded::at_hand(names.size())) return;
  int values = 0;
  for (const char* name : names) {
    SCOPED_TRACE(name);
    const auto [database, expected] = load(name);
    for (const json& expected_message : expected["messages"]) {
      const Message* message = find(database, expected_message);
      ASSERT_NE(message, nullptr);
      const auto bindings = bindings_of(*message);
      Decoder decoder({&database, 1}, bindings, {}, {});
      for (const json& vector : expected_message["vectors"]) {
        SCOPED_TRACE(message->name + ' ' + vector["data"].dump());
        const auto payload = bytes_of(vector["data"].get<std::string>());
        ASSERT_EQ(payload.size(), message->length);
        std::vector<std::uint8_t> covered(payload.size());  // bits of signals
        std::size_t present = 0;
        std::map<std::string, double> bound;
        for (const Signal& signal : message->signals) {
          if (!is_present(*message, signal, payload)) continue;
          ++present;
          SCOPED_TRACE(signal.name);
          const SignalLayout layout = layout_of(signal);
          insert_bits(layout, ~std::uint64_t{0}, covered);
          if (!vector.contains("raw")) continue;  // the other decoder failed
          ASSERT_TRUE(vector["raw"].contains(signal.name));
          const json& raw = vector["raw"][signal.name];
          const double physical = vector["phys"][signal.name].get<double>();
          const std::uint64_t bits = extract_bits(layout, payload);
          if (signal.type == ValueType::signed_integer)
            EXPECT_EQ(sign_extended(bits, signal.length), raw.get<std::int64_t>());
          else
            EXPECT_EQ(bits, raw.get<std::uint64_t>());
          EXPECT_EQ(physical_value(layout, bits), physical);
          if (&signal - message->signals.data() < std::ssize(bindings))
            bound[signal.name] = physical;
          ++values;
        }
        for (std::size_t i = 0; i < payload.size(); ++i) covered[i] &= payload[i];
        Frame frame = encoded_again(*message, payload);
        ASSERT_TRUE(std::ranges::equal(frame.payload(), covered));
        if (!vector.contains("raw")) continue;
        EXPECT_EQ(present, vector["raw"].size());
        std::ranges::copy(payload, frame.data.begin());
        std::array<Sample, max_samples_per_frame> samples;
        std::map<std::string, double> decoded;
        for (const Sample& sample : std::span(samples).first(decoder.decode(frame, samples).count))
          decoded[message->signals[sample.channel].name] = sample.value;
        EXPECT_EQ(decoded, bound);
      }
    }
  }
  std::printf("decoded %d values\n", values);
  EXPECT_GT(values, 40'000);
}

}  // namespace
}  // namespace odomd::can::real_databases_test
