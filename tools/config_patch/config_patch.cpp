#include "tools/config_patch/config_patch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "daemon/core/config_keys.hpp"
#include "daemon/core/config_toml.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

/// The default value of a missing list, which is then written completely; empty if the key is not a
/// list.
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
      : text_(text), file_(file), value_(value), root_(daemon::parse_toml(text, file)) {
    const std::size_t bracket = value.key.find('[');
    if (bracket != std::string::npos) element_ = std::stoul(value.key.substr(bracket + 1));
    std::istringstream names(value.key.substr(0, bracket));
    for (std::string name; std::getline(names, name, '.');) names_.push_back(name);
  }

  void apply() {
    if (!std::isfinite(value_.value)) fail(fmt::format("{} cannot be written", value_.value));
    const toml::node* const node = find();
    if (node == nullptr)
      add();
    else
      replace(*node);
    verify();
  }

  /// The current value.
  [[nodiscard]] std::optional<ConfigValue> current() {
    const toml::node* const node = find();
    if (node == nullptr) return std::nullopt;
    const std::optional<double> number = node->value<double>();
    if (!number) fail("is not a number; correct it, or give another key", node);
    return ConfigValue{value_.key, *number,
                       toml_note(text_, offset(node->source().begin), label())};
  }

 private:
  /// "car.toml:7: [camera] lever_arm[2]: ...", like the configuration's own errors.
  [[noreturn]] void fail(const std::string& what, const toml::node* node = nullptr) const {
    const std::size_t dot = value_.key.rfind('.');
    throw std::invalid_argument(
        fmt::format("{}{}: {}{}: {}", file_.string(),
                    node == nullptr ? "" : fmt::format(":{}", node->source().begin.line),
                    dot == std::string::npos ? "" : fmt::format("[{}] ", value_.key.substr(0, dot)),
                    value_.key.substr(dot + 1), what));
  }

  [[nodiscard]] std::size_t offset(const toml::source_position& place) const {
    return toml_offset(text_, place.line, place.column);
  }

  /// The key's node, or null. Fills tables_ with the existing tables on the path to it.
  const toml::node* find() {
    const toml::node* node = &root_;
    for (const std::string& name : names_) {
      const toml::table* const table = node->as_table();
      if (table == nullptr) fail("is inside a value that is not a table", node);
      tables_.push_back(table);
      node = table->get(name);
      if (node == nullptr) return nullptr;
    }
    if (!element_) return node;
    const toml::array* const list = node->as_array();
    if (list == nullptr) fail("must be a list of numbers", node);
    if (*element_ >= list->size())
      fail(fmt::format("the list has {} elements only", list->size()), node);
    return list->get(*element_);
  }

  void replace(const toml::node& node) {
    if (!node.is_number()) fail("is not a number; correct it", &node);
    const std::size_t begin = offset(node.source().begin);
    const std::size_t width = offset(node.source().end) - begin;
    const std::string number = toml_number(value_.value);
    // Comments of neighbouring lines are often aligned: keep that.
    if (const TomlLine line = toml_line(text_, begin); line.comment < line.end) {
      std::size_t blanks = line.comment;
      while (text_[blanks - 1] == ' ') --blanks;
      const std::size_t now = line.comment - blanks;
      if (now > 1)
        text_.replace(blanks, now, std::max(now + width, number.size() + 2) - number.size(), ' ');
    }
    text_.replace(begin, width, number);
    set_toml_note(text_, begin, label(), value_.note);
  }

  /// The label that says which number of a line a note is about; empty if the line has only one.
  [[nodiscard]] std::string label() const {
    std::string text;
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (!text.empty() || (i < tables_.size() && tables_[i]->is_inline()))
        text += (text.empty() ? "" : ".") + names_[i];
    if (element_) text += fmt::format("[{}]", *element_);
    return text;
  }

  /// Inserts the number in the braces of an inline table, below the last entry of a [table], or in
  /// a new [table] at the end. verify() rejects a text in which none of these works.
  void add() {
    const toml::table& table = *tables_.back();
    const auto missing = names_.begin() + std::ssize(tables_) - 1, last = names_.end() - 1;
    std::string entry = toml_number(value_.value);
    if (element_) {
      std::vector<std::string> numbers;
      for (const double number : list_with_value()) numbers.push_back(toml_number(number));
      entry = fmt::format("[{}]", fmt::join(numbers, ", "));
    }
    entry = fmt::format("{} = {}", fmt::join(table.is_inline() ? missing : last, names_.end(), "."),
                        entry);
    const std::size_t first = text_.find('\n');
    const bool dos = first != std::string::npos && first > 0 && text_[first - 1] == '\r';
    const std::string eol = dos ? "\r\n" : "\n";
    std::size_t at = text_.size();
    if (table.is_inline()) {
      const std::size_t brace = offset(table.source().end) - 1;
      at = text_.find_last_not_of(" \t", brace - 1) + 1;
      if (table.empty()) text_.erase(at, brace - at);
      entry = table.empty() ? " " + entry + " " : ", " + entry;
    } else if (tables_.size() > 1 && missing == last) {
      const auto [above, end] = last_line_of(table);
      at = end;
      entry = eol + above + entry;
    } else {
      entry =
          fmt::format("{}{}[{}]{}{}", text_.empty() || text_.back() == '\n' ? "" : eol,
                      text_.empty() ? "" : eol, fmt::join(names_.begin(), last, "."), eol, entry);
      text_ += eol;
    }
    text_.insert(at, entry);
    set_toml_note(text_, at + entry.size(), label(), value_.note);
  }

  [[nodiscard]] std::vector<double> list_with_value() const {
    const daemon::ConfigKey* key = daemon::config_key(value_.key);
    std::vector<double> list =
        key == nullptr ? std::vector<double>{} : std::visit(DefaultList{}, key->member);
    if (*element_ >= list.size()) fail("there is no such list; give the whole list");
    list[*element_] = value_.value;
    return list;
  }

  /// The indent and the end of a table's last entry, or of its header if there is no entry.
  [[nodiscard]] std::pair<std::string, std::size_t> last_line_of(const toml::table& table) const {
    toml::source_region last = table.source();
    last.end.line = last.begin.line;
    for (const auto& [key, node] : table)
      if ((!node.is_table() || node.as_table()->is_inline()) &&
          node.source().end.line >= last.end.line)
        last = node.source();
    const std::size_t begin = toml_line(text_, offset(last.begin)).begin;
    return {text_.substr(begin, text_.find_first_not_of(" \t", begin) - begin),
            toml_line(text_, toml_offset(text_, last.end.line, 1)).end};
  }

  /// Checks the result: apart from the one number, it must mean the same as before.
  void verify() {
    toml::table* table = &root_;
    for (std::size_t i = 0; i + 1 < names_.size(); ++i) {
      table->emplace<toml::table>(names_[i]);
      table = (*table)[names_[i]].as_table();
    }
    if (!element_) {
      table->insert_or_assign(names_.back(), value_.value);
    } else if (toml::array* const list = (*table)[names_.back()].as_array()) {
      list->replace(list->cbegin() + static_cast<std::ptrdiff_t>(*element_), value_.value);
    } else {
      toml::array whole;
      for (const double number : list_with_value()) whole.push_back(number);
      table->insert_or_assign(names_.back(), std::move(whole));
    }
    try {
      if (toml::parse(text_) == root_) return;
    } catch (const toml::parse_error&) {  // invalid TOML is refused as well
    }
    fail(fmt::format("cannot be inserted into this text; write {} there by hand",
                     toml_number(value_.value)));
  }

  std::string& text_;
  const fs::path& file_;
  const ConfigValue& value_;
  toml::table root_;
  std::vector<std::string> names_;
  std::optional<std::size_t> element_;      // index in a list
  std::vector<const toml::table*> tables_;  // the existing ones, from the root down
};

}  // namespace

std::optional<ConfigValue> value_in(const std::string& text, const std::filesystem::path& file,
                                    const std::string& key) {
  std::string same = text;
  return Patch(same, file, {.key = key}).current();
}

std::string patched(const std::string& text, const std::filesystem::path& file,
                    std::span<const ConfigValue> values) {
  std::string result = text;
  for (const ConfigValue& value : values) Patch(result, file, value).apply();
  return result;
}

}  // namespace odomd::tools
