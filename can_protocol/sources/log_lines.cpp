#include "can_protocol/sources/log_lines.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/printable.hpp"

namespace odomd::can {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

bool is_hex(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

bool is_control(char c) {
  return (static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\r') || c == '\x7F';
}

/// Whether the line has a CAN XL frame, "45123#81:00:12345678#11": its identifier has 5 digits.
bool has_xl_frame(std::string_view line) {
  const std::size_t at = line.find('#');
  return at != std::string_view::npos && at > 5 && line.find(':', at) == at + 3 &&
         std::ranges::all_of(line.substr(at - 5, 5), is_hex);
}

/// Whether a line without a frame is a fragment of a frame, or is not text.
bool is_damaged(std::string_view line) {
  if (std::ranges::any_of(line, is_control)) return true;
  const std::string_view text = line.substr(line.find_first_not_of(" \t"));
  if (text.front() == '(') return !has_xl_frame(text);
  const std::size_t at = text.find('#');
  return at != std::string_view::npos && at > 0 && is_hex(text[at - 1]);
}

std::string count_of(std::uint64_t lines, std::string_view one, std::string_view several) {
  return std::to_string(lines) + ' ' + std::string(lines == 1 ? one : several);
}

}  // namespace

std::optional<std::string_view> LineBuffer::next_line() noexcept {
  const char* const from = data_.get() + scanned_;
  const void* const newline = std::memchr(from, '\n', end_ - scanned_);
  if (newline == nullptr) {
    scanned_ = end_;
    if (begin_ == 0 && end_ == capacity) return last_line();
    return std::nullopt;
  }
  const auto length =
      static_cast<std::size_t>(static_cast<const char*>(newline) - (data_.get() + begin_));
  const std::string_view line(data_.get() + begin_, length);
  begin_ += length + 1;
  scanned_ = begin_;
  ++line_number_;
  return line;
}

std::optional<std::string_view> LineBuffer::last_line() noexcept {
  if (begin_ == end_) return std::nullopt;
  const std::string_view line(data_.get() + begin_, end_ - begin_);
  begin_ = scanned_ = end_;
  ++line_number_;
  return line;
}

/// Moves the unread rest to the front before it reads more; nothing else is copied.
LineBuffer::Fill LineBuffer::fill(int descriptor) noexcept {
  if (begin_ != 0) {
    std::memmove(data_.get(), data_.get() + begin_, end_ - begin_);
    end_ -= begin_;
    scanned_ -= begin_;
    begin_ = 0;
  }
  const ssize_t got = ::read(descriptor, data_.get() + end_, capacity - end_);
  if (got > 0) {
    end_ += static_cast<std::size_t>(got);
    return Fill::data;
  }
  if (got == 0) return Fill::end;
  return errno == EINTR || errno == EAGAIN ? Fill::again : Fill::error;
}

std::string at_line(const std::string& label, std::uint64_t line_number) {
  return label + ":" + std::to_string(line_number) + ": ";
}

LogLines::LogLines(std::string label, BusNames& buses) : label_(std::move(label)), buses_(buses) {}

LineKind LogLines::read(std::string_view text, std::uint64_t line_number, LineEnd end,
                        Frame& frame) {
  if (line_number == 1 && text.starts_with(byte_order_mark))
    text.remove_prefix(byte_order_mark.size());
  text_ = text;
  number_ = line_number;
  kind_ = classify(text, frame);
  if (kind_ == LineKind::frame) ++frames_;
  if (kind_ == LineKind::frame || kind_ == LineKind::blank) return kind_;
  if (first_problem_.empty()) first_problem_ = problem();
  if (kind_ == LineKind::damaged && end == LineEnd::end_of_log) {
    kind_ = LineKind::cut_off;
    cut_off_ = problem();
  } else if (kind_ == LineKind::damaged) {
    count(damaged_, line_number);
  } else if (kind_ == LineKind::passed_over) {
    if (passed_over_.lines == 0) first_passed_over_ = quoted(text);
    count(passed_over_, line_number);
  }
  return kind_;
}

LineKind LogLines::classify(std::string_view text, Frame& frame) {
  if (text.find_first_not_of(" \t\r") == std::string_view::npos) return LineKind::blank;
  parsed_ = parse_candump_line(text);
  if (!parsed_.good()) return is_damaged(text) ? LineKind::damaged : LineKind::passed_over;
  if (parsed_.interface != last_interface_) {
    const auto bus = buses_.index_of(parsed_.interface);
    if (!bus) return LineKind::bus_too_many;
    last_interface_ = parsed_.interface;
    last_bus_ = *bus;
  }
  frame = parsed_.frame;
  frame.bus = last_bus_;
  return LineKind::frame;
}

void LogLines::count(Tally& tally, std::uint64_t line_number) {
  if (tally.lines++ == 0) tally.first = line_number;
  if (tally.lines == 1 || line_number > tally.last + 1) ++tally.stretches;
  tally.last = line_number;
}

std::string LogLines::problem() const {
  const std::string place = at_line(label_, number_);
  if (kind_ == LineKind::bus_too_many)
    return place + quoted(parsed_.interface) + " is one bus too many; odomd reads at most " +
           std::to_string(max_buses) + " buses: remove the others from the log";
  if (kind_ == LineKind::passed_over)
    return place + quoted(text_) + " is no frame; a line looks like " +
           std::string(candump_example);
  if (kind_ == LineKind::cut_off) return place + "the last line is cut off and is ignored";
  return place + "expected " + std::string(parsed_.expected) + " at column " +
         std::to_string(parsed_.column) + "; a line looks like " + std::string(candump_example);
}

std::vector<std::string> LogLines::warnings() const {
  std::vector<std::string> all;
  if (passed_over_.lines > 0)
    all.push_back(
        at_line(label_, passed_over_.first) +
        count_of(passed_over_.lines, "line is no frame and was", "lines are no frames and were") +
        " passed over, the first is " + first_passed_over_);
  if (damaged_.lines > 0)
    all.push_back(at_line(label_, damaged_.first) + "the log is damaged here" +
                  (damaged_.stretches > 1 ? " and in " + count_of(damaged_.stretches - 1,
                                                                  "other place", "other places")
                                          : std::string{}) +
                  ": " + count_of(damaged_.lines, "line is", "lines are") +
                  " left out; --strict refuses such a log");
  if (!cut_off_.empty()) all.push_back(cut_off_);
  return all;
}

}  // namespace odomd::can
