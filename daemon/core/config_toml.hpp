// Reads TOML tables: checks the type and range of every value when it is read. The keys that were
// read are the valid keys, so misspelt keys are found. Private to the configuration and to the code
// that patches it: nothing else uses toml++.
#pragma once

#include <toml++/toml.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/core/config_keys.hpp"

namespace odomd::daemon {

/// One table of the file. Every call with a key makes the key known; finish() rejects all others.
/// All errors are ConfigErrors that name file, line, table and key.
class TableReader {
 public:
  /// `name` is the name of the table in errors: "[can.signals] yaw_rate".
  TableReader(const toml::table& table, std::string name, const std::filesystem::path& file)
      : table_(&table), name_(std::move(name)), file_(&file) {}

  [[nodiscard]] bool has(std::string_view key);
  [[nodiscard]] bool is_text(std::string_view key) const { return (*table_)[key].is_string(); }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::filesystem::path& file() const { return *file_; }

  /// Reads a key into `value`; without the key `value` is unchanged.
  void read(std::string_view key, double& value, const Range& range);
  void read(std::string_view key, std::string& value);
  void read(std::string_view key, std::filesystem::path& value);  ///< relative to the file
  void read(std::string_view key, int& value, int lowest, int highest);
  void read_mode(std::string_view key, std::uint32_t& value);  ///< file mode: 0o660 or "0660"
  void read_seconds(std::string_view key, std::int64_t& nanoseconds, const Range& range);
  void read(std::string_view key, std::span<double> values, const Range& range);
  void read(std::string_view key, std::vector<std::uint8_t>& bytes, std::size_t count);
  void read(std::string_view key, std::vector<std::int64_t>& values);       ///< a list
  void read_texts(std::string_view key, std::vector<std::string>& values);  ///< one, or a list

  /// The index of the value in `names`. Case-insensitive.
  [[nodiscard]] std::optional<std::size_t> read_choice(std::string_view key,
                                                       std::span<const std::string_view> names);

  /// The table of this name inside this one, if it exists.
  [[nodiscard]] std::optional<TableReader> table(std::string_view key, std::string name);

  /// The table of this name inside this one, or the tables of a list; empty if the key is absent.
  [[nodiscard]] std::vector<TableReader> tables(std::string_view key, const std::string& name);

  /// All keys with their tables; every value must be a table.
  [[nodiscard]] std::vector<std::pair<std::string, TableReader>> tables();

  /// Rejects unknown keys.
  void finish() const;

  [[noreturn]] void fail(std::string_view key, const std::string& what) const;
  /// Like the above, but about the table as a whole.
  [[noreturn]] void fail(const std::string& what) const { fail("", what); }
  /// Throws when the table has one of these keys, which do not apply to it.
  void refuse(std::initializer_list<std::string_view> keys, const std::string& why);
  /// Throws when the key is missing; `fix` follows "is missing". Names a misspelt key, if any.
  void require(std::string_view key, std::string_view fix = "");

 private:
  const toml::node* find(std::string_view key);
  [[nodiscard]] double number(std::string_view key, const toml::node& node,
                              const Range& range) const;
  [[nodiscard]] std::string text(std::string_view key, const toml::node& node) const;

  const toml::table* table_;
  std::string name_;
  const std::filesystem::path* file_;
  std::vector<std::string> known_;
};

/// The text of the file, read once, since it may be a pipe. Throws with one line.
[[nodiscard]] std::string read_toml_file(const std::filesystem::path& file);
[[nodiscard]] toml::table parse_toml(const std::string& text, const std::filesystem::path& file);

/// "; did you mean \"mass\"?": names the nearest valid name.
[[nodiscard]] std::string suggestion(std::string_view name, std::span<const std::string> names);

}  // namespace odomd::daemon
