// A minute of a real car's two buses, compared with the values of an independent decoder.
#include <charconv>
#include <map>
#include <sstream>
#include <tuple>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"
#include "tests/recorded_drives.hpp"

namespace odomd::can::real_traffic_test {
namespace {

using FrameKey = std::tuple<std::int64_t, int, std::uint32_t>;  // time [us], bus, identifier

struct GoldenValue {
  std::string message;
  std::string signal;
  double value = 0.0;
};

std::int64_t microseconds(std::string stamp) {
  stamp.erase(stamp.find('.'), 1);
  return std::stoll(stamp);
}

std::map<FrameKey, std::vector<GoldenValue>> read_golden(const std::filesystem::path& file) {
  std::map<FrameKey, std::vector<GoldenValue>> golden;
  std::istringstream in(recorded::text_of(file));
  std::string line;
  std::getline(in, line);  // t_s,bus,id_hex,message,signal,value
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream cells_in(line);
    for (std::string cell; std::getline(cells_in, cell, ',');) cells.push_back(cell);
    double value = 0.0;
    std::from_chars(cells.at(5).data(), cells[5].data() + cells[5].size(), value);
    golden[{microseconds(cells[0]), std::stoi(cells[1]),
            static_cast<std::uint32_t>(std::stoul(cells[2], nullptr, 16))}]
        .push_back({cells[3], cells[4], value});
  }
  return golden;
}

TEST(RealTraffic, DecodesExactlyAsAnIndependentToolDoes) {
  if (!recorded::at_hand(1)) return;
  const auto folder = recorded::folder("rav4");
  const std::vector<Database> databases{read_dbc(folder / "car.dbc")};
  const auto golden = read_golden(folder / "golden_decode.csv");

  // Decodes signal by signal, and through the decoder with every signal bound.
  std::vector<SignalBinding> bindings;
  std::vector<const Signal*> channels;
  for (const Message& message : databases[0].messages)
    for (const Signal& signal : message.signals) {
      if (&signal - message.signals.data() >= static_cast<int>(max_samples_per_frame)) break;
      bindings.push_back(
          binding_of(message.name, signal.name, static_cast<std::uint16_t>(channels.size())));
      channels.push_back(&signal);
    }
  Decoder decoder(databases, bindings, {}, {});

  BusNames buses;
  LogReader log((folder / "drive.log").string(), buses);
  std::size_t frames = 0;
  std::size_t values = 0;
  std::size_t decoded_values = 0;
  while (const auto* frame = log.next()) {
    ++frames;
    std::array<Sample, max_samples_per_frame> samples;
    const DecodeResult result = decoder.decode(*frame, samples);
    const int bus = frame->bus;  // 0: can0, which occurs first
    const auto expected = golden.find({frame->time_ns / 1000, bus, frame->id});
    if (expected == golden.end()) continue;
    const Message* message = find_message(databases[0], expected->second[0].message);
    ASSERT_NE(message, nullptr);
    EXPECT_EQ(message->id, frame->id);
    EXPECT_EQ(message->signals.size(), expected->second.size());
    EXPECT_EQ(result.verdict, FrameVerdict::decoded);
    for (const GoldenValue& value : expected->second) {
      SCOPED_TRACE(value.message + '.' + value.signal);
      const Signal* signal = find_signal(*message, value.signal);
      ASSERT_NE(signal, nullptr);
      const SignalLayout layout = layout_of(*signal);
      EXPECT_EQ(physical_value(layout, extract_bits(layout, frame->payload())), value.value);
      ++values;
      for (const Sample& sample : std::span(samples).first(result.count))
        if (channels[sample.channel] == signal) {
          EXPECT_EQ(sample.value, value.value);
          EXPECT_EQ(sample.time_ns, frame->time_ns);
          ++decoded_values;
        }
    }
  }
  EXPECT_EQ(frames, 98'800U);
  EXPECT_EQ(values, 5'060U);
  EXPECT_EQ(decoded_values, 5'060U);
}

/// Converts every signal of every frame to its physical value and back to the same bits.
TEST(RealTraffic, EncodesBackToThePayloadsItCameFrom) {
  if (!recorded::at_hand(1)) return;
  const auto folder = recorded::folder("rav4");
  const Database database = read_dbc(folder / "car.dbc");
  std::map<std::uint32_t, MessageEncoder> encoders;
  for (const Message& message : database.messages)
    encoders.try_emplace(frame_key(message.id, message.format), message);
  BusNames buses;
  LogReader log((folder / "drive.log").string(), buses);
  std::size_t values = 0;
  while (const auto* frame = log.next()) {
    const auto found = encoders.find(frame_key(*frame));
    if (found == encoders.end()) continue;
    MessageEncoder& encoder = found->second;
    const Message& message = encoder.message();
    for (const Signal& signal : message.signals) {
      const SignalLayout layout = layout_of(signal);
      if (frame->length < layout.bytes_needed) continue;
      const std::uint64_t bits = extract_bits(layout, frame->payload());
      encoder.set(signal.name, physical_value(layout, bits));
      ASSERT_EQ(extract_bits(layout, encoder.frame(0).payload()), bits)
          << message.name << '.' << signal.name;
      ++values;
    }
  }
  EXPECT_GT(values, 200'000U);
}

}  // namespace
}  // namespace odomd::can::real_traffic_test
