// The candump grammar: a cursor over the line, one function per field.
#include "can_protocol/sources/candump.hpp"

#include <algorithm>
#include <array>

#include "base/seconds.hpp"

namespace odomd::can {
namespace {

constexpr std::uint32_t error_flag = 0x2000'0000;
constexpr std::uint32_t id_mask = 0x1FFF'FFFF;
constexpr std::uint32_t max_standard_id = 0x7FF;
constexpr std::size_t max_classic_payload = 8;
constexpr std::size_t max_interface = 63;  // the kernel's names are shorter still
// Leaves years of margin below the 64-bit limit for moving a stamp to another clock.
constexpr std::int64_t max_seconds = 9'000'000'000;
constexpr std::uint8_t no_digit = 0xFF;

constexpr std::array<std::uint8_t, 256> hex_values = [] {
  std::array<std::uint8_t, 256> values{};
  values.fill(no_digit);
  for (unsigned i = 0; i < 10; ++i) values['0' + i] = static_cast<std::uint8_t>(i);
  for (unsigned i = 0; i < 6; ++i)
    values['a' + i] = values['A' + i] = static_cast<std::uint8_t>(10 + i);
  return values;
}();

class Parser {
 public:
  Parser(std::string_view line, CandumpLine& out) : line_(line), out_(out) {}

  void parse() noexcept {
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    skip_blanks();
    if (stamp() && interface() && identifier() && content()) direction();
  }

 private:
  [[nodiscard]] char peek() const noexcept { return at_ < line_.size() ? line_[at_] : '\0'; }
  [[nodiscard]] std::uint8_t peek_digit() const noexcept {
    return hex_values[static_cast<unsigned char>(peek())];
  }

  bool take(char wanted) noexcept {
    if (peek() != wanted || at_ == line_.size()) return false;
    ++at_;
    return true;
  }

  bool skip_blanks() noexcept {
    const std::size_t start = at_;
    while (peek() == ' ' || peek() == '\t') ++at_;
    return at_ != start;
  }

  bool fail(std::string_view expected) noexcept { return fail(expected, at_); }
  bool fail(std::string_view expected, std::size_t at) noexcept {
    out_.expected = expected;
    out_.column = at + 1;
    return false;
  }

  bool stamp() noexcept {
    if (!take('(')) return fail("'(' and a stamp in seconds");
    std::int64_t seconds = 0;
    const std::size_t start = at_;
    for (; peek() >= '0' && peek() <= '9'; ++at_) {
      seconds = seconds * 10 + (peek() - '0');
      if (seconds > max_seconds) return fail("a stamp before the year 2255");
    }
    if (at_ == start) return fail("the seconds of the stamp");
    if (!take('.')) return fail("'.' and 6 or 9 decimals of the stamp");
    std::int64_t fraction = 0;
    std::size_t decimals = 0;
    for (; decimals < 10 && peek() >= '0' && peek() <= '9'; ++at_, ++decimals)
      fraction = fraction * 10 + (peek() - '0');
    if (decimals != 6 && decimals != 9) return fail("6 or 9 decimals of the stamp");
    if (decimals == 6) fraction *= 1000;
    if (!take(')')) return fail("')' after the stamp");
    out_.frame.time_ns = seconds * ns_per_s + fraction;
    return true;
  }

  bool interface() noexcept {
    if (!skip_blanks()) return fail("a space and the interface");
    const std::size_t start = at_;
    while (peek() > ' ' && peek() <= '~') ++at_;
    if (at_ == start) return fail("the interface");
    if (at_ - start > max_interface) return fail("an interface of at most 63 characters", start);
    out_.interface = line_.substr(start, at_ - start);
    if (!skip_blanks()) return fail("a space and the frame");
    return true;
  }

  bool identifier() noexcept {
    std::uint32_t value = 0;
    const std::size_t start = at_;
    for (; at_ - start < 8 && peek_digit() != no_digit; ++at_) value = value << 4U | peek_digit();
    const std::size_t digits = at_ - start;
    if (digits == 3 && peek() == '#') {
      if (value > max_standard_id)
        return fail("an identifier up to 7FF (an extended one has 8 digits)", start);
    } else if (digits == 8 && peek() == '#') {
      if (value > (error_flag | id_mask))
        return fail("an identifier up to 1FFFFFFF, or an error frame (20000000 and its class)",
                    start);
      if ((value & error_flag) != 0)
        out_.frame.kind = FrameKind::error;
      else
        out_.frame.format = IdFormat::extended;
    } else {
      return fail("an identifier of 3 or 8 hexadecimal digits and '#'");
    }
    out_.frame.id = value & id_mask;
    ++at_;  // the '#'
    return true;
  }

  bool content() noexcept {
    Frame& frame = out_.frame;
    if (take('#')) {
      if (frame.kind == FrameKind::error) return fail("the payload of an error frame, not CAN FD");
      const std::uint8_t flags = peek_digit();
      if (flags == no_digit) return fail("the digit of the CAN FD flags");
      ++at_;
      frame.protocol = FrameProtocol::fd;
      frame.fd_flags = flags & 0x3U;  // the kernel may also set bit 2, "this is CAN FD"
      if (!payload(max_payload)) return false;
      return is_fd_length(frame.length) ||
             fail("a CAN FD payload of 0-8, 12, 16, 20, 24, 32, 48 or 64 bytes");
    }
    if (frame.kind != FrameKind::error && (peek() == 'R' || peek() == 'r')) {
      ++at_;
      frame.kind = FrameKind::remote;
      if (peek() >= '0' && peek() <= '8') {
        frame.length = static_cast<std::uint8_t>(peek() - '0');
        ++at_;
      }
    } else if (!payload(max_classic_payload)) {
      return false;
    }
    if (frame.length == max_classic_payload && take('_')) {
      if (peek_digit() == no_digit || peek_digit() < 9) return fail("a raw length code, 9 to F");
      ++at_;
    }
    return true;
  }

  bool payload(std::size_t most) noexcept {
    Frame& frame = out_.frame;
    std::size_t length = 0;
    while (length < most) {
      const std::uint8_t high = peek_digit();
      if (high == no_digit) break;
      ++at_;
      const std::uint8_t low = peek_digit();
      if (low == no_digit) return fail("the second digit of a payload byte");
      ++at_;
      frame.data[length++] = static_cast<std::uint8_t>(high << 4U | low);
      if (peek() == '.') ++at_;
    }
    frame.length = static_cast<std::uint8_t>(length);
    return true;
  }

  void direction() noexcept {
    if (skip_blanks() && (peek() == 'R' || peek() == 'T')) {
      ++at_;
      skip_blanks();
    }
    if (at_ != line_.size())
      fail(out_.frame.length == 0 || peek_digit() == no_digit
               ? "payload bytes in hexadecimal, then the end of the line"
               : "the end of the line: the payload is longer than the frame can be");
  }

  std::string_view line_;
  std::size_t at_ = 0;
  CandumpLine& out_;
};

void append_digits(std::string& out, std::uint64_t value, std::size_t digits) {
  std::array<char, 20> text{};
  std::size_t at = text.size();
  while (value != 0 || text.size() - at < digits) {
    text[--at] = static_cast<char>('0' + value % 10);
    value /= 10;
  }
  out.append(text.data() + at, text.size() - at);
}

void append_hex(std::string& out, std::uint32_t value, unsigned digits) {
  constexpr std::string_view hex = "0123456789ABCDEF";
  for (unsigned shift = digits * 4; shift != 0; shift -= 4)
    out.push_back(hex[value >> (shift - 4) & 0xFU]);
}

}  // namespace

CandumpLine parse_candump_line(std::string_view line) noexcept {
  CandumpLine out;
  Parser(line, out).parse();
  return out;
}

void append_candump_line(std::string& out, const Frame& frame, std::string_view interface,
                         StampDecimals decimals) {
  const auto time = static_cast<std::uint64_t>(std::max<std::int64_t>(frame.time_ns, 0));
  out.push_back('(');
  append_digits(out, time / ns_per_s, 10);
  out.push_back('.');
  if (decimals == StampDecimals::six)
    append_digits(out, time % ns_per_s / 1000, 6);
  else
    append_digits(out, time % ns_per_s, 9);
  out.append(") ").append(interface).push_back(' ');

  if (frame.kind == FrameKind::error)
    append_hex(out, frame.id | error_flag, 8);
  else
    append_hex(out, frame.id, frame.format == IdFormat::extended ? 8 : 3);
  out.push_back('#');
  if (frame.kind == FrameKind::remote) {
    out.push_back('R');
    if (frame.length != 0) append_digits(out, frame.length, 1);
  } else {
    if (frame.protocol == FrameProtocol::fd) {
      out.push_back('#');
      append_hex(out, frame.fd_flags & 0x3U, 1);
    }
    for (const std::uint8_t byte : frame.payload()) append_hex(out, byte, 2);
  }
  out.push_back('\n');
}

}  // namespace odomd::can
