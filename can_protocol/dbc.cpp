// Databases: from a file, and look-ups by name.
#include "can_protocol/dbc.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "can_protocol/dbc_lexer.hpp"

namespace odomd::can {

Database read_dbc(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, ignored))
    throw DbcError(file.string() + ": cannot be read; name a DBC file that exists");
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (text.empty()) throw DbcError(file.string() + ": empty; name a DBC file with messages (BO_)");
  Database database = parse_dbc(text, file.string());
  if (database.messages.empty())
    throw DbcError(file.string() + ": no message (BO_) in it; name a DBC file");
  return database;
}

std::string describe(const Database& database, const Warning& warning) {
  return at_line(database.file, warning.line, warning.text);
}

const Message* find_message(const Database& database, std::string_view name) {
  const auto found = std::find_if(database.messages.begin(), database.messages.end(),
                                  [name](const Message& message) { return message.name == name; });
  return found == database.messages.end() ? nullptr : &*found;
}

const Signal* find_signal(const Message& message, std::string_view name) {
  const auto found = std::find_if(message.signals.begin(), message.signals.end(),
                                  [name](const Signal& signal) { return signal.name == name; });
  return found == message.signals.end() ? nullptr : &*found;
}

}  // namespace odomd::can
