#include "tools/import/csv_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

constexpr std::size_t max_header_line = 200;
/// In the order of preference: commas may be decimal ones.
constexpr std::string_view delimiters = "\t;,";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t\r";
  const auto first = text.find_first_not_of(space);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(space) - first + 1);
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return result;
}

bool is_missing(std::string_view cell) {
  constexpr std::array<std::string_view, 12> texts{"",   "nan", "-nan", "null", "none", "n/a",
                                                   "na", "-",   "--",   "inf",  "-inf", "infinity"};
  return cell.size() < 9 && std::ranges::find(texts, lower(cell)) != texts.end();
}

/// "#3" -> 2
std::optional<std::size_t> index_in(std::string_view column) {
  std::size_t number = 0;
  if (!column.starts_with('#')) return std::nullopt;
  const auto [end, error] =
      std::from_chars(column.data() + 1, column.data() + column.size(), number);
  if (error != std::errc{} || end != column.data() + column.size() || number == 0)
    return std::nullopt;
  return number - 1;
}

bool is_number(std::string_view cell, char delimiter) {
  return !cell.empty() && parse_cell(cell, delimiter).has_value();
}

}  // namespace

NameAndUnit split_unit(std::string_view column) {
  column = trimmed(column);
  if (column.size() < 3 || (column.back() != ')' && column.back() != ']')) return {column, {}};
  const auto open = column.rfind(column.back() == ')' ? '(' : '[');
  if (open == std::string_view::npos || open == 0) return {column, {}};
  return {trimmed(column.substr(0, open)), column.substr(open + 1, column.size() - open - 2)};
}

std::optional<double> parse_cell(std::string_view text, char delimiter) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::string with_point;
  if (delimiter != ',' && std::ranges::count(text, ',') == 1 && text.find('.') == text.npos) {
    with_point = text;
    std::ranges::replace(with_point, ',', '.');
    text = with_point;
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && std::isfinite(value))
    return value;
  if (const std::string word = text.size() < 6 ? lower(text) : "";
      word == "true" || word == "false")
    return word == "true" ? 1.0 : 0.0;
  return std::nullopt;
}

CsvTable::CsvTable(const std::filesystem::path& file, std::span<const std::string> wanted)
    : name_(file.string()) {
  auto input = open_input(file);
  text_.assign(std::istreambuf_iterator<char>(input), {});
  if (input.bad()) throw std::runtime_error(name_ + ": cannot be read");
  if (text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
  if (text_.find('\0') != std::string::npos)
    throw std::invalid_argument(name_ +
                                ": is not a text in UTF-8; if it is a table in UTF-16, convert it: "
                                "iconv -f UTF-16 -t UTF-8");
  find_layout(wanted);
  take_units();
}

std::optional<std::string_view> CsvTable::read_line() {
  if (offset_ >= text_.size()) return std::nullopt;
  const std::size_t end = std::min(text_.find('\n', offset_), text_.size());
  const std::string_view line = std::string_view(text_).substr(offset_, end - offset_);
  offset_ = end + 1;
  ++line_;
  return line;
}

std::vector<std::string> CsvTable::split(std::string_view line, char delimiter) const {
  std::vector<std::string> cells;
  for (bool more = true; more;) {
    line.remove_prefix(std::min(line.find_first_not_of(" \r"), line.size()));
    std::string cell;
    if (line.starts_with('"')) {
      std::size_t end = 1;
      for (; end < line.size(); ++end) {
        if (line[end] == '"' && (++end == line.size() || line[end] != '"')) break;
        cell += line[end];
      }
      line.remove_prefix(std::min(end, line.size()));
    }
    const std::size_t end = line.find(delimiter);
    cell += trimmed(line.substr(0, end));
    cells.push_back(std::move(cell));
    more = end != std::string_view::npos;
    line.remove_prefix(more ? end + 1 : line.size());
  }
  return cells;
}

struct CsvTable::Layout {
  std::size_t names = 0;  // wanted ones
  bool has_words = false;
  std::size_t offset = 0, line = 0;  // behind it
  char delimiter = ',';
  std::vector<std::string> columns;
};

// Without any of the names, the header is the first line of several words: it has the names to
// suggest. A table whose columns are named by their numbers begins at its first line of numbers.
void CsvTable::find_layout(std::span<const std::string> wanted) {
  const bool by_number = std::ranges::any_of(
      wanted, [](const std::string& name) { return index_in(name).has_value(); });
  Layout best;
  std::vector<std::size_t> seen_with(delimiters.size());
  std::optional<std::size_t> first_offset;
  std::size_t first_line = 0;
  for (std::size_t begin = 0; line_ < max_header_line; begin = offset_) {
    const auto line = read_line();
    if (!line) break;
    if (trimmed(*line).empty()) continue;
    for (std::size_t i = 0; i < delimiters.size(); ++i) {
      Layout layout{.offset = offset_, .line = line_, .delimiter = delimiters[i]};
      layout.columns = split(*line, layout.delimiter);
      if (layout.columns.size() > 1) ++seen_with[i];
      if (layout.columns.front().starts_with("# "))
        layout.columns.front() = trimmed(std::string_view(layout.columns.front()).substr(1));
      for (const std::string& name : wanted)
        layout.names += std::ranges::any_of(layout.columns,
                                            [&](const std::string& cell) {
                                              return cell == name || split_unit(cell).name == name;
                                            })
                            ? 1U
                            : 0U;
      layout.has_words = layout.columns.size() > 1 &&
                         std::ranges::none_of(layout.columns, [&](const std::string& cell) {
                           return is_number(cell, layout.delimiter);
                         });
      if (by_number && !first_offset && layout.columns.size() > 1 &&
          std::ranges::any_of(layout.columns, [&](const std::string& cell) {
            return is_number(cell, layout.delimiter);
          })) {
        first_offset = begin;
        first_line = line_ - 1;
      }
      if (layout.names > best.names ||
          (best.columns.empty() && layout.has_words && layout.columns.size() > 1))
        best = std::move(layout);
    }
  }
  if (line_ == 0) throw std::invalid_argument(name_ + ": is empty; a table is expected");
  if (best.names == 0 && by_number) {
    const auto most = std::ranges::max_element(seen_with);
    delimiter_ = delimiters[static_cast<std::size_t>(most - seen_with.begin())];
    offset_ = first_offset.value_or(text_.size());
    line_ = first_line;
    return;
  }
  if (best.columns.empty())
    throw std::invalid_argument(
        name_ +
        ": has no line of column names; name the columns by their numbers: yaw_rate=#3, --time #1");
  columns_ = std::move(best.columns);
  delimiter_ = best.delimiter;
  offset_ = best.offset;
  line_ = best.line;
}

// A row below the header without any number.
void CsvTable::take_units() {
  const std::size_t offset = offset_, line = line_;
  while (!columns_.empty()) {
    const auto row = read_line();
    if (!row) break;
    if (trimmed(*row).empty()) continue;
    auto cells = split(*row, delimiter_);
    if (cells.size() != columns_.size() || std::ranges::any_of(cells, [&](const std::string& cell) {
          return cell.find_first_of("0123456789:") != cell.npos && cell.find('/') == cell.npos;
        }))
      break;
    units_ = std::move(cells);
    return;
  }
  offset_ = offset;
  line_ = line;
}

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  const auto without_unit = [](const std::string& name) { return split_unit(name).name; };
  auto found = std::ranges::find(columns_, column);
  bool is_twice =
      found != columns_.end() && std::find(found + 1, columns_.end(), column) != columns_.end();
  if (found == columns_.end()) {
    found = std::ranges::find(columns_, column, without_unit);
    if (found == columns_.end()) return index_in(column);
    is_twice = std::ranges::find(found + 1, columns_.end(), column, without_unit) != columns_.end();
  }
  if (is_twice)
    throw std::invalid_argument(
        fmt::format("{}: column {} occurs twice; name it by its number, #{}", name_,
                    tools::quoted(column), found - columns_.begin() + 1));
  return static_cast<std::size_t>(found - columns_.begin());
}

std::string_view CsvTable::unit(std::size_t column) const {
  if (column < columns_.size())
    if (const auto unit = split_unit(columns_[column]).unit; !unit.empty()) return unit;
  return column < units_.size() ? std::string_view(units_[column]) : std::string_view();
}

bool CsvTable::next() {
  while (const auto line = read_line()) {
    const std::string_view content = trimmed(*line);
    if (content.empty() || content.starts_with('#')) continue;
    cells_ = split(*line, delimiter_);
    if (columns_.empty()) return true;
    while (cells_.size() > columns_.size() && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() == columns_.size()) return true;
    if (cells_.size() + 1 == columns_.size() && columns_.back().empty()) return true;
    if (offset_ > text_.size() && cells_.size() < columns_.size()) return false;
    throw std::invalid_argument(
        fmt::format("{}: {} cells where the header has {}; correct or remove the line", place(),
                    cells_.size(), columns_.size()));
  }
  return false;
}

double CsvTable::progress() const {
  return static_cast<double>(std::min(offset_, text_.size())) / static_cast<double>(text_.size());
}

std::string_view CsvTable::cell(std::size_t column) const {
  if (column >= cells_.size() || is_missing(cells_[column])) return {};
  return cells_[column];
}

std::optional<double> CsvTable::number(std::size_t column) const {
  const std::string_view text = cell(column);
  if (text.empty()) return std::nullopt;
  const auto value = parse_cell(text, delimiter_);
  if (!value)
    fail(column, tools::quoted(text) + " is not a number; correct the cell, or leave it empty");
  return value;
}

std::string CsvTable::place() const {
  return fmt::format("{}:{}", name_, line_);
}

void CsvTable::fail(std::size_t column, const std::string& what) const {
  throw std::invalid_argument(fmt::format(
      "{}: column {}: {}", place(),
      column < columns_.size() ? tools::quoted(columns_[column]) : fmt::format("#{}", column + 1),
      what));
}

}  // namespace odomd::tools
