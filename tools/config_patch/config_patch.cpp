#include "tools/config_patch/config_patch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include "daemon/core/config_keys.hpp"
#include "daemon/core/config_toml.hpp"
#include "tools/cli/csv.hpp"
#include "tools/config_patch/toml_lines.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

/// "camera.lever_arm[2]": names, and at the end perhaps an element of a list.
struct Path {
  std::vector<std::string> names;
  std::optional<std::size_t> element;
};

Path path_of(const std::string& key) {
  Path path;
  const std::size_t end = std::min(key.find('['), key.size());
  if (end < key.size()) path.element = std::stoul(key.substr(end + 1));
  for (std::size_t at = 0; at < end;) {
    const std::size_t dot = std::min(key.find('.', at), end);
    path.names.push_back(key.substr(at, dot - at));
    at = dot + 1;
  }
  return path;
}

/// "[camera] lever_arm[2]", as the configuration's own errors have it.
std::string shown(const Path& path) {
  const std::vector<std::string> tables(path.names.begin(), path.names.end() - 1);
  return (tables.empty() ? "" : fmt::format("[{}] ", fmt::join(tables, "."))) + path.names.back() +
         (path.element ? fmt::format("[{}]", *path.element) : "");
}

/// The shortest form that reads back to the same bits, always with a decimal point or exponent.
std::string number_text(double value) {
  std::string text;
  append_number(text, value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// A missing list is written completely: what the configuration takes where it is missing; empty
/// if the key is no list.
struct DefaultList {
  daemon::Config config;

  template <std::size_t size>
  std::vector<double> operator()(daemon::Member<std::array<double, size>> member) {
    return {member(config).begin(), member(config).end()};
  }
  std::vector<double> operator()(daemon::Member<std::optional<std::array<double, 3>>>) {
    return std::vector<double>(3);
  }
  std::vector<double> operator()(daemon::Member<std::optional<estimator::Pose2>>) {
    return std::vector<double>(3);
  }
  std::vector<double> operator()(const auto&) { return {}; }
};

class Patch {
 public:
  Patch(std::string& text, const fs::path& file, const ConfigValue& value)
      : text_(text),
        file_(file),
        value_(value),
        path_(path_of(value.key)),
        root_(daemon::parse_toml(text, file)) {}

  void apply() {
    if (!std::isfinite(value_.value))
      throw std::invalid_argument(
          fmt::format("{}: {}: {} cannot be written", file_.string(), shown(path_), value_.value));
    const toml::node* const node = find();
    if (node == nullptr)
      add();
    else
      replace(path_.element ? element_of(*node) : *node);
    verify();
  }

  /// The present value.
  [[nodiscard]] std::optional<ConfigValue> there() {
    const toml::node* node = find();
    if (node != nullptr && path_.element) node = &element_of(*node);
    if (node == nullptr) return std::nullopt;
    const std::optional<double> number = node->value<double>();
    if (!number) fail(*node, "is not a number; correct it, or give another key");
    return ConfigValue{value_.key, *number,
                       toml_note(text_, offset(node->source().begin), label())};
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw std::invalid_argument(
        fmt::format("{}:{}: {}: {}", file_.string(), node.source().begin.line, shown(path_), what));
  }

  [[nodiscard]] std::size_t offset(const toml::source_position& place) const {
    return toml_offset(text_, place.line, place.column);
  }

  /// Fills tables_ with the tables on the way, as far as there are any.
  const toml::node* find() {
    const toml::node* node = &root_;
    for (const std::string& name : path_.names) {
      const toml::table* const table = node->as_table();
      if (table == nullptr) fail(*node, "is inside a value that is not a table");
      tables_.push_back(table);
      node = table->get(name);
      if (node == nullptr) return nullptr;
    }
    return node;
  }

  [[nodiscard]] const toml::node& element_of(const toml::node& node) const {
    const toml::array* const list = node.as_array();
    if (list == nullptr) fail(node, "must be a list of numbers");
    if (*path_.element >= list->size())
      fail(node, fmt::format("the list has {} elements only", list->size()));
    return *list->get(*path_.element);
  }

  void replace(const toml::node& node) {
    if (!node.is_number()) fail(node, "is not a number; correct it");
    const std::size_t begin = offset(node.source().begin);
    const std::size_t end = offset(node.source().end);
    const std::string number = number_text(value_.value);
    // Comments of neighbouring lines are often aligned: keep that.
    if (const std::size_t comment = toml_comment(text_, begin); comment != std::string::npos) {
      std::size_t blanks = comment;
      while (text_[blanks - 1] == ' ') --blanks;
      const std::size_t now = comment - blanks;
      const std::size_t width = now + (end - begin);
      if (now > 1)
        text_.replace(blanks, now, std::max(width, number.size() + 2) - number.size(), ' ');
    }
    text_.replace(begin, end - begin, number);
    set_toml_note(text_, begin, label(), value_.note);
  }

  /// The label that says which number of a line a note is about; empty if the line has only one.
  [[nodiscard]] std::string label() const {
    std::string text;
    for (std::size_t i = 0; i < path_.names.size(); ++i)
      if (!text.empty() || (i < tables_.size() && tables_[i]->is_inline()))
        text += (text.empty() ? "" : ".") + path_.names[i];
    if (path_.element) text += fmt::format("[{}]", *path_.element);
    return text;
  }

  /// Into the braces of an inline table, below the last entry of a [table], or in a new [table] at
  /// the end. What needs another shape, verify() refuses.
  void add() {
    std::string value = number_text(value_.value);
    if (path_.element) {
      std::vector<std::string> numbers;
      for (const double number : list_with_value()) numbers.push_back(number_text(number));
      value = fmt::format("[{}]", fmt::join(numbers, ", "));
    }
    const toml::table& table = *tables_.back();
    const auto missing = path_.names.begin() + static_cast<std::ptrdiff_t>(tables_.size()) - 1;
    if (table.is_inline())
      add_in_braces(table,
                    fmt::format("{} = {}", fmt::join(missing, path_.names.end(), "."), value));
    else if (tables_.size() > 1 && tables_.size() == path_.names.size())
      add_line(table, path_.names.back() + " = " + value);
    else
      add_table(path_.names.back() + " = " + value);
  }

  [[nodiscard]] std::vector<double> list_with_value() const {
    const daemon::ConfigKey* key = daemon::config_key(value_.key);
    std::vector<double> list =
        key == nullptr ? std::vector<double>{} : std::visit(DefaultList{}, key->member);
    if (*path_.element >= list.size())
      throw std::invalid_argument(fmt::format("{}: {}: there is no such list; give the whole list",
                                              file_.string(), shown(path_)));
    list[*path_.element] = value_.value;
    return list;
  }

  void add_in_braces(const toml::table& table, const std::string& entry) {
    const std::size_t brace = offset(table.source().end) - 1;
    std::size_t at = brace;
    while (text_[at - 1] == ' ' || text_[at - 1] == '\t') --at;
    if (table.empty())
      text_.replace(at, brace - at, " " + entry + " ");
    else
      text_.insert(at, ", " + entry);
    set_toml_note(text_, at, label(), value_.note);
  }

  [[nodiscard]] std::string line_break() const {
    const std::size_t at = text_.find('\n');
    return at != std::string::npos && at > 0 && text_[at - 1] == '\r' ? "\r\n" : "\n";
  }

  void add_line(const toml::table& table, const std::string& entry) {
    toml::source_region last = table.source();  // of the header, or of the last entry
    last.end.line = last.begin.line;
    for (const auto& [key, node] : table)
      if ((!node.is_table() || node.as_table()->is_inline()) &&
          node.source().end.line >= last.end.line)
        last = node.source();
    const TomlLine above = toml_line(text_, offset(last.begin));
    const std::size_t at = toml_line(text_, toml_offset(text_, last.end.line, 1)).end;
    const std::string indent =
        text_.substr(above.begin, text_.find_first_not_of(" \t", above.begin) - above.begin);
    const std::string added = line_break() + indent + entry;
    text_.insert(at, added);
    set_toml_note(text_, at + added.size(), label(), value_.note);
  }

  void add_table(const std::string& entry) {
    const std::string eol = line_break();
    std::string added;
    if (!text_.empty() && text_.back() != '\n') added += eol;
    if (!text_.empty()) added += eol;
    const auto last = path_.names.end() - 1;
    text_ += added + fmt::format("[{}]", fmt::join(path_.names.begin(), last, ".")) + eol + entry;
    const std::size_t at = text_.size();
    text_ += eol;
    set_toml_note(text_, at, label(), value_.note);
  }

  /// Checks the result: apart from the one number it must mean the same as before.
  void verify() {
    toml::table* table = &root_;
    for (std::size_t i = 0; i + 1 < path_.names.size(); ++i) {
      table->emplace<toml::table>(path_.names[i]);
      table = (*table)[path_.names[i]].as_table();
    }
    const std::string& name = path_.names.back();
    if (!path_.element) {
      table->insert_or_assign(name, value_.value);
    } else if (toml::array* const list = (*table)[name].as_array()) {
      list->replace(list->cbegin() + static_cast<std::ptrdiff_t>(*path_.element), value_.value);
    } else {
      toml::array whole;
      for (const double number : list_with_value()) whole.push_back(number);
      table->insert_or_assign(name, std::move(whole));
    }
    bool same = false;
    try {
      same = toml::parse(text_) == root_;
    } catch (const toml::parse_error&) {  // then it is not
    }
    if (!same)
      throw std::invalid_argument(
          fmt::format("{}: {}: cannot be inserted into this text; write {} there by hand",
                      file_.string(), shown(path_), number_text(value_.value)));
  }

  std::string& text_;
  const fs::path& file_;
  const ConfigValue& value_;
  Path path_;
  toml::table root_;
  std::vector<const toml::table*> tables_;  // from the root down, the existing ones
};

}  // namespace

std::optional<ConfigValue> value_in(const std::string& text, const std::filesystem::path& file,
                                    const std::string& key) {
  std::string same = text;
  return Patch(same, file, {.key = key}).there();
}

std::string patched(const std::string& text, const std::filesystem::path& file,
                    std::span<const ConfigValue> values) {
  std::string result = text;
  for (const ConfigValue& value : values) Patch(result, file, value).apply();
  return result;
}

}  // namespace odomd::tools
