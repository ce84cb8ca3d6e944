#include "tools/cli/csv.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <stdexcept>
#include <utility>

namespace odomd::tools {
namespace {

// The year 2115; limited so that the difference of two times fits too.
constexpr std::int64_t latest_ns = 4'600'000'000LL * 1'000'000'000;

// Far longer than any row of ours; a longer line means that the file is not text.
constexpr std::size_t max_line = 65'536;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t\r";
  const auto first = text.find_first_not_of(space);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(space) - first + 1);
}

}  // namespace

CsvReader::CsvReader(std::istream& input, std::string name, std::vector<std::string> columns,
                     LastLine last_line, CsvLayout layout)
    : input_(input),
      name_(std::move(name)),
      columns_(std::move(columns)),
      last_line_(last_line),
      layout_(layout) {
  layout_.required = std::min(layout_.required, columns_.size());
  const std::string wanted = joined(std::span(columns_).first(layout_.required));
  while (line_number_ + 1 < layout_.header_line && read_line()) {
  }
  if (layout_.header_line == 0) {
    line_ = wanted;
  } else if (!read_line()) {
    throw std::invalid_argument(name_ + ": is empty; a first line \"" + wanted + "\" is expected");
  }
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (line_.starts_with(byte_order_mark)) line_.erase(0, byte_order_mark.size());
  split_cells(line_, layout_, fields_);
  header_fields_ = fields_.size();
  for (std::size_t column = 0; column < columns_.size(); ++column) {
    const auto found = std::find(fields_.begin(), fields_.end(), columns_[column]);
    if (found == fields_.end()) {
      if (column < layout_.required) {
        throw std::invalid_argument(place() + ": no column " + odomd::quoted(columns_[column]) +
                                    "; the header is " + odomd::quoted(trimmed(line_)) +
                                    ", it needs " + wanted);
      }
      positions_.emplace_back();
      continue;
    }
    if (std::find(found + 1, fields_.end(), columns_[column]) != fields_.end()) {
      throw std::invalid_argument(place() + ": column \"" + columns_[column] +
                                  "\" occurs twice; remove one");
    }
    positions_.emplace_back(static_cast<std::size_t>(found - fields_.begin()));
  }
}

bool CsvReader::next() {
  while (read_line()) {
    const std::string_view content = trimmed(line_);
    if (content.empty() || content.front() == layout_.comment) continue;
    split_cells(line_, layout_, fields_);
    while (layout_.quote && fields_.size() > header_fields_ && fields_.back().empty())
      fields_.pop_back();
    if (line_end_ == LineEnd::end_of_input) {
      if (last_line_ == LastLine::drop_unended || fields_.size() < header_fields_) {
        warnings_.push_back(place() +
                            ": the last line is cut off (no newline at its end); ignored");
        return false;
      }
      warnings_.push_back(place() +
                          ": the last line has no newline at its end; used, but its last number is "
                          "wrong if it was cut off");
    }
    if (fields_.size() != header_fields_) {
      throw std::invalid_argument(place() + ": " + std::to_string(fields_.size()) +
                                  " fields where the header has " + std::to_string(header_fields_) +
                                  "; correct or remove the line");
    }
    return true;
  }
  return false;
}

double CsvReader::number(std::size_t column) const {
  const std::string_view field = text(column);
  const auto value = parse_number(field);
  if (!value || !std::isfinite(*value))
    fail(column, quoted(field) + " is not a finite number; correct or remove the line");
  return *value;
}

std::int64_t CsvReader::time_ns(std::size_t column) const {
  const std::string_view field = text(column);
  const auto value = parse_seconds(field);
  if (!value || *value > latest_ns || *value < -latest_ns) {
    fail(column, quoted(field) + " is not a time in seconds; correct or remove the line");
  }
  return *value;
}

std::size_t CsvReader::word(std::size_t column, std::span<const std::string_view> words,
                            std::string_view otherwise) const {
  const auto found = std::ranges::find(words, text(column));
  if (found == words.end()) fail(column, quoted(text(column)).append(otherwise));
  return static_cast<std::size_t>(found - words.begin());
}

std::string_view CsvReader::text(std::size_t column) const {
  return fields_[positions_[column].value()];
}

void CsvReader::fail(std::size_t column, const std::string& what) const {
  throw std::invalid_argument(place() + ": column \"" + columns_[column] + "\": " + what);
}

std::string CsvReader::place() const {
  return name_ + ':' + std::to_string(line_number_);
}

bool CsvReader::read_line() {
  std::array<char, 4096> piece{};
  line_.clear();
  while (true) {
    input_.getline(piece.data(), piece.size());
    const auto count = static_cast<std::size_t>(input_.gcount());
    if (input_.bad()) throw std::runtime_error(name_ + ": cannot be read");
    if (input_.eof()) {
      line_.append(piece.data(), count);
      line_end_ = LineEnd::end_of_input;
      if (line_.empty()) return false;
      break;
    }
    if (!input_.fail()) {  // the newline is counted but not stored
      line_.append(piece.data(), count - 1);
      line_end_ = LineEnd::newline;
      break;
    }
    input_.clear();  // the line is longer than the piece
    line_.append(piece.data(), count);
    if (line_.size() > max_line) {
      throw std::invalid_argument(name_ + ':' + std::to_string(line_number_ + 1) +
                                  ": the line is longer than 64 KiB; is this a CSV file?");
    }
  }
  ++line_number_;
  return true;
}

void split_cells(std::string& line, const CsvLayout& layout, std::vector<std::string_view>& cells) {
  cells.clear();
  std::size_t begin = 0;
  while (true) {
    std::size_t end = begin;
    const std::size_t first = std::min(line.find_first_not_of(' ', begin), line.size());
    if (first < line.size() && line[first] == layout.quote) {
      std::size_t kept = first, next = first + 1;
      for (; next < line.size(); ++next) {
        if (line[next] == layout.quote && (++next == line.size() || line[next] != layout.quote))
          break;
        line[kept++] = line[next];
      }
      cells.push_back(trimmed(std::string_view(line).substr(first, kept - first)));
      end = line.find(layout.delimiter, next);
    } else {
      end = line.find(layout.delimiter, begin);
      cells.push_back(trimmed(std::string_view(line).substr(begin, end - begin)));
    }
    if (end == std::string::npos) return;
    begin = end + 1;
  }
}

std::optional<std::int64_t> parse_seconds(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const std::size_t letter = std::min(text.find_first_of("eE"), text.size());
  std::string digits{text.substr(0, letter)};
  const std::size_t dot = std::min(digits.find('.'), digits.size());
  if (dot < digits.size()) digits.erase(dot, 1);
  if (digits.empty() || digits.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  std::optional<int> exponent = 0;
  if (letter < text.size()) {
    text.remove_prefix(letter + 1);
    if (text.starts_with('+')) text.remove_prefix(1);
    exponent = parse_number<int>(text);
    if (!exponent) return std::nullopt;
  }
  const std::size_t zeros = digits.find_first_not_of('0');
  if (zeros == std::string::npos) return 0;
  digits.erase(0, zeros);

  constexpr std::int64_t nanosecond_digits = 9;
  const std::int64_t count =  // digits of the whole nanoseconds
      static_cast<std::int64_t>(dot) - static_cast<std::int64_t>(zeros) + *exponent +
      nanosecond_digits;
  if (count < 0) return 0;
  if (count > 19) return std::nullopt;
  const auto end = static_cast<std::size_t>(count);
  digits.resize(std::max(digits.size(), end + 1), '0');
  std::int64_t ns = 0;
  if (end > 0 && std::from_chars(digits.data(), digits.data() + end, ns).ec != std::errc{})
    return std::nullopt;
  if (digits[end] >= '5' && __builtin_add_overflow(ns, 1, &ns)) return std::nullopt;
  return negative ? -ns : ns;
}

void append_number(std::string& out, double value, int decimals) {
  std::array<char, 64> text;
  char* const limit = text.data() + text.size();
  const auto [end, error] =
      decimals == all_digits
          ? std::to_chars(text.data(), limit, value)
          : std::to_chars(text.data(), limit, value, std::chars_format::fixed, decimals);
  if (error != std::errc{}) throw std::runtime_error("a number has too many digits for a file");
  out.append(text.data(), end);
}

std::string toml_number(double value) {
  std::string text;
  append_number(text, value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

void append_seconds(std::string& out, std::int64_t time_ns) {
  constexpr std::uint64_t second = 1'000'000'000;
  // The magnitude of the most negative number only fits the unsigned type.
  const auto magnitude = time_ns < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(time_ns)
                                     : static_cast<std::uint64_t>(time_ns);
  std::array<char, 32> text;
  char* end = text.data();
  if (time_ns < 0) *end++ = '-';
  end = std::to_chars(end, text.data() + text.size(), magnitude / second).ptr;
  *end++ = '.';
  std::uint64_t fraction = magnitude % second;
  for (char* digit = end + 9; digit != end; fraction /= 10)
    *--digit = static_cast<char>('0' + fraction % 10);
  out.append(text.data(), end + 9);
}

std::string joined(std::span<const std::string> names) {
  return fmt::format("{}", fmt::join(names, ","));
}

}  // namespace odomd::tools
