#include "daemon/core/config_toml.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>

#include <fmt/format.h>

#include "base/input_file.hpp"
#include "base/nearest_name.hpp"

namespace odomd::daemon {
namespace {

constexpr std::uintmax_t largest_file = 1 << 20;
/// The library recurses with each part of a dotted key; it limits only the depth of brackets.
constexpr std::ptrdiff_t max_dots_per_line = 200;

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

/// Any number. (value<double>() would be empty for an integer that a double has to round.)
std::optional<double> number_in(const toml::node& node) {
  if (const auto whole = node.value_exact<std::int64_t>()) return static_cast<double>(*whole);
  return node.value_exact<double>();
}

bool equal_but_for_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

bool Range::contains(double value) const {
  return std::isfinite(value) && value <= highest &&
         (lowest_included ? value >= lowest : value > lowest);
}

void TableReader::fail(std::string_view key, const std::string& what) const {
  const toml::node* node = table_->get(key);
  const auto line = (node != nullptr ? node->source() : table_->source()).begin.line;
  throw ConfigError(fmt::format("{}:{}: {}{}{}: {}", file_->string(), std::max(line, 1U), name_,
                                name_.empty() || key.empty() ? "" : " ", key, what));
}

const toml::node* TableReader::find(std::string_view key) {
  if (std::ranges::find(known_, key) == known_.end()) known_.emplace_back(key);
  return table_->get(key);
}

bool TableReader::has(std::string_view key) {
  return find(key) != nullptr;
}

void TableReader::refuse(std::initializer_list<std::string_view> keys, const std::string& why) {
  for (const std::string_view key : keys)
    if (has(key)) fail(key, why);
}

void TableReader::require(std::string_view key, std::string_view fix) {
  if (has(key)) return;
  for (const auto& [other, node] : *table_)
    if (std::ranges::find(known_, other.str()) == known_.end() && resembles(other.str(), key))
      fail(other.str(), fmt::format("unknown key; did you mean \"{}\"?", key));
  fail(key, fmt::format("is missing{}", fix));
}

double TableReader::number(std::string_view key, const toml::node& node, const Range& range) const {
  const auto value = number_in(node);
  if (!value) fail(key, fmt::format("is {}; it must be a number", kind_of(node)));
  if (!range.contains(*value))
    fail(key, fmt::format(
                  "{} is not possible; it must be {}{}", *value,
                  std::isfinite(*value) || range.text == any_number.text ? "" : "a finite number, ",
                  range.text));
  return *value;
}

std::string TableReader::text(std::string_view key, const toml::node& node) const {
  if (!node.is_string())
    fail(key, fmt::format("is {}; it must be a text in quotes", kind_of(node)));
  auto value = *node.value<std::string>();
  if (std::ranges::any_of(value,
                          [](char c) { return std::iscntrl(static_cast<unsigned char>(c)); }))
    fail(key, "holds a control character");
  return value;
}

void TableReader::read(std::string_view key, double& value, const Range& range) {
  if (const auto* node = find(key)) value = number(key, *node, range);
}

void TableReader::read(std::string_view key, std::string& value) {
  if (const auto* node = find(key)) value = text(key, *node);
}

void TableReader::read(std::string_view key, std::filesystem::path& value) {
  if (const auto* node = find(key)) {
    const auto given = text(key, *node);
    if (given.empty()) fail(key, "is empty; it must name a file");
    value = std::filesystem::absolute(file_->parent_path() / given).lexically_normal();
  }
}

void TableReader::read(std::string_view key, int& value, int lowest, int highest) {
  if (const auto* node = find(key)) {
    const auto given = node->value_exact<std::int64_t>();
    if (!given)
      fail(key, node->is_floating_point()
                    ? fmt::format("{} is not possible; it must be a whole number, {} to {}, "
                                  "without a point or an exponent",
                                  *node->value<double>(), lowest, highest)
                    : fmt::format("is {}; it must be a whole number, {} to {}", kind_of(*node),
                                  lowest, highest));
    if (*given < lowest || *given > highest)
      fail(key, fmt::format("{} is not possible; it must be {} to {}", *given, lowest, highest));
    value = static_cast<int>(*given);
  }
}

void TableReader::read_mode(std::string_view key, std::uint32_t& value) {
  const auto* node = find(key);
  if (node == nullptr) return;
  auto given = node->value_exact<std::int64_t>();
  if (node->is_string()) {
    const auto digits = text(key, *node);
    const bool octal = !digits.empty() && digits.size() <= 5 &&
                       std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '7'; });
    if (octal) given = std::stoi(digits, nullptr, 8);
  }
  if (!given || *given < 0 || *given > 0777) fail(key, "is not a file mode; write it as 0o660");
  value = static_cast<std::uint32_t>(*given);
}

void TableReader::read_seconds(std::string_view key, std::int64_t& nanoseconds,
                               const Range& range) {
  if (const auto* node = find(key)) nanoseconds = std::llround(number(key, *node, range) * 1e9);
}

void TableReader::read(std::string_view key, std::span<double> values, const Range& range) {
  const auto* node = find(key);
  if (node == nullptr) return;
  const auto* list = node->as_array();
  if (list == nullptr || list->size() != values.size())
    fail(key, fmt::format("must be a list of {} numbers", values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(key, (*list)[i], range);
}

void TableReader::read(std::string_view key, std::vector<std::uint8_t>& bytes, std::size_t count) {
  const auto* node = find(key);
  if (node == nullptr) return;
  const auto* list = node->as_array();
  if (list == nullptr || list->size() != count)
    fail(key, fmt::format("must be a list of {} whole numbers", count));
  bytes.clear();
  for (const auto& element : *list) {
    const auto byte = element.value_exact<std::int64_t>();
    if (!byte || *byte < 0 || *byte > 255) fail(key, "must hold whole numbers from 0 to 255");
    bytes.push_back(static_cast<std::uint8_t>(*byte));
  }
}

void TableReader::read(std::string_view key, std::vector<std::int64_t>& values) {
  const auto* node = find(key);
  if (node == nullptr) return;
  if (!node->is_array())
    fail(key, fmt::format("is {}; it must be a list of whole numbers", kind_of(*node)));
  for (const auto& element : *node->as_array()) {
    const auto value = element.value_exact<std::int64_t>();
    if (!value) fail(key, "must hold whole numbers");
    values.push_back(*value);
  }
}

void TableReader::read_texts(std::string_view key, std::vector<std::string>& values) {
  const auto* node = find(key);
  if (node == nullptr) return;
  values.clear();
  if (const auto* list = node->as_array()) {
    for (const auto& element : *list) values.push_back(text(key, element));
    if (values.empty()) fail(key, "is an empty list");
  } else {
    values.push_back(text(key, *node));
  }
  if (std::ranges::find(values, "") != values.end()) fail(key, "holds an empty name");
}

std::optional<std::size_t> TableReader::read_choice(std::string_view key,
                                                    std::span<const std::string_view> names) {
  const auto* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto given = text(key, *node);
  const auto found =
      std::ranges::find_if(names, [&](auto name) { return equal_but_for_case(name, given); });
  if (found == names.end()) {
    const std::vector<std::string> all(names.begin(), names.end());
    fail(key, fmt::format("\"{}\" is not known{}", given, suggestion(given, all)));
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::optional<TableReader> TableReader::table(std::string_view key, std::string name) {
  const auto* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_table()) fail(key, fmt::format("is {}; it must be a table", kind_of(*node)));
  return TableReader(*node->as_table(), std::move(name), *file_);
}

std::vector<TableReader> TableReader::tables(std::string_view key, const std::string& name) {
  const auto* node = find(key);
  if (node == nullptr || !node->is_array()) {
    auto single = table(key, name);
    return single ? std::vector{std::move(*single)} : std::vector<TableReader>{};
  }
  std::vector<TableReader> all;
  for (const auto& element : *node->as_array()) {
    if (!element.is_table())
      fail(key, fmt::format("holds {}; it must hold tables", kind_of(element)));
    all.emplace_back(*element.as_table(), name, *file_);
  }
  if (all.empty()) fail(key, "is an empty list");
  return all;
}

std::vector<std::pair<std::string, TableReader>> TableReader::tables() {
  std::vector<std::pair<std::string, TableReader>> all;
  for (const auto& [key, node] : *table_) {
    const std::string text(key.str());
    all.emplace_back(text, *table(text, name_ + " " + text));
  }
  // In the order of the file, so that the first error reported is the first one in it.
  std::ranges::stable_sort(
      all, {}, [](const auto& entry) { return entry.second.table_->source().begin.line; });
  return all;
}

void TableReader::finish() const {
  for (const auto& [key, node] : *table_)
    if (std::ranges::find(known_, key.str()) == known_.end())
      fail(key.str(), "unknown key" + suggestion(key.str(), known_));
}

std::string read_toml_file(const std::filesystem::path& file) {
  const auto unusable = [&](std::string_view what) {
    throw ConfigError(fmt::format("{}: {}", file.string(), what));
  };
  if (const std::string problem = problem_with_input(file); !problem.empty()) unusable(problem);
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    unusable(fmt::format("cannot be read: {}{}", std::strerror(errno),
                         errno == ENOENT ? "; check the path" : ""));
  std::string text;
  // Does not rely on the file size: the file may be a pipe.
  for (char c = 0; text.size() <= largest_file && stream.get(c);) text.push_back(c);
  if (stream.bad()) unusable("cannot be read");
  if (text.size() > largest_file) unusable("is larger than 1 MiB; is this the configuration?");
  if (const auto nul = text.find('\0'); nul != std::string::npos) {
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n');
    throw ConfigError(fmt::format("{}:{}: holds a NUL byte; the file is damaged or not a text",
                                  file.string(), line));
  }
  return text;
}

toml::table parse_toml(const std::string& text, const std::filesystem::path& file) {
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number)
    if (line.find_first_not_of(" \t") != line.find('#') &&  // no comment
        std::ranges::count(line, '.') > max_dots_per_line)
      throw ConfigError(
          fmt::format("{}:{}: has more than {} dots; write the tables that a key means",
                      file.string(), number, max_dots_per_line));
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& parse_error) {
    std::string what(parse_error.description());
    std::ranges::replace_if(
        what, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)); }, ' ');
    if (what.starts_with("Error while parsing floating-point") && what.ends_with("as a value"))
      what += "; a number is at most 1.8e308 in size";
    static const std::regex decimal_comma(R"(([\w-]+)\s*=\s*(?:[-+]?\d+,\d|\[.*\d,0\d))");
    lines.clear();
    lines.seekg(0);
    for (auto left = parse_error.source().begin.line; left > 0; --left) std::getline(lines, line);
    line.resize(std::min(line.size(), std::size_t{1000}));  // the matcher recurses
    if (std::smatch match; std::regex_search(line, match, decimal_comma))
      what += fmt::format("; {}: write a number with a decimal point: 2.5, not 2,5", match.str(1));
    throw ConfigError(
        fmt::format("{}:{}: not TOML: {}", file.string(), parse_error.source().begin.line, what));
  }
}

std::string suggestion(std::string_view name, std::span<const std::string> names) {
  if (names.empty()) return "; this table has no keys";
  return fmt::format("; did you mean \"{}\"?", nearest_name(name, names));
}

}  // namespace odomd::daemon
