// Any text as a database is refused in one line, or all its signals can be bound, decoded and
// encoded safely.
#include "can_protocol/dbc/dbc.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/decode/message_encoder.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace odomd::can {
namespace {

using fuzz::require;
using fuzz::require_one_line;

/// Binds as many signals of a message as one frame may yield.
void decode_and_encode(const Database& database, const Message& message) {
  std::vector<SignalBinding> bindings;
  for (const Signal& signal : message.signals) {
    if (bindings.size() == max_samples_per_frame) break;
    bindings.push_back(
        binding_of(message.name, signal.name, static_cast<std::uint16_t>(bindings.size())));
  }
  try {
    Decoder decoder(std::span(&database, 1), bindings, {}, {});
    Frame frame{.id = message.id, .format = message.format, .length = message.length};
    std::array<Sample, max_samples_per_frame> samples;
    for (const std::uint8_t fill : std::array<std::uint8_t, 3>{0x00, 0xFF, 0x5A}) {
      frame.data.fill(fill);
      const DecodeResult result = decoder.decode(frame, samples);
      require(result.count <= bindings.size(), "no more samples than signals");
    }
  } catch (const std::invalid_argument& error) {
    require_one_line(error.what());
  }
  MessageEncoder encoder(message);
  for (const Signal& signal : message.signals) {
    try {
      encoder.set(signal.name, 1e300);
      encoder.set(signal.name, -1.5);
      encoder.set_bits(signal.name, ~std::uint64_t{0});
    } catch (const std::invalid_argument& error) {
      require_one_line(error.what());
    }
  }
  require(encoder.frame(1).length == message.length, "the frame is as long as its message");
}

void read(std::string_view text) {
  try {
    const Database database = parse_dbc(text, "fuzz.dbc");
    for (const Warning& warning : database.warnings) require_one_line(describe(database, warning));
    const std::size_t messages = std::min<std::size_t>(database.messages.size(), 4);
    for (std::size_t i = 0; i < messages; ++i) decode_and_encode(database, database.messages[i]);
  } catch (const DbcError& error) {
    require_one_line(error.what());
  }
}

}  // namespace
}  // namespace odomd::can

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  odomd::can::read({reinterpret_cast<const char*>(data), size});
  return 0;
}
