// Any line is either refused with a column inside it, or gives a valid frame that is the same after
// writing and reading it.
#include "can_protocol/sources/candump.hpp"

#include <string>

#include "tests/fuzz/fuzz.hpp"

using odomd::can::append_candump_line;
using odomd::can::CandumpLine;
using odomd::can::Frame;
using odomd::can::parse_candump_line;
using odomd::fuzz::require;

namespace {

bool same(const Frame& a, const Frame& b) {
  return a.time_ns == b.time_ns && a.id == b.id && a.format == b.format && a.kind == b.kind &&
         a.protocol == b.protocol && a.length == b.length && a.fd_flags == b.fd_flags &&
         a.data == b.data;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const CandumpLine line = parse_candump_line(text);
  if (!line.good()) {
    require(line.column >= 1 && line.column <= size + 1, "the column is in the line");
    return 0;
  }
  require(line.frame.time_ns >= 0, "the stamp is not negative");
  require(line.frame.length <= odomd::can::max_payload, "the payload fits");
  require(!line.interface.empty(), "there is an interface");
  std::string written;
  append_candump_line(written, line.frame, line.interface, odomd::can::StampDecimals::nine);
  require(written.back() == '\n', "a line ends with a newline");
  written.pop_back();
  const CandumpLine again = parse_candump_line(written);
  require(again.good(), "what is written can be read");
  require(same(line.frame, again.frame), "what is read is what was written");
  require(line.interface == again.interface, "the interface is the same");
  return 0;
}
