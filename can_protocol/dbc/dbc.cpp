// Reads databases from files, and looks up messages by name.
#include "can_protocol/dbc/dbc.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "can_protocol/dbc/lexer.hpp"

namespace odomd::can {
namespace {

/// Databases of production cars have a tenth of this size.
constexpr std::size_t largest_file = std::size_t{16} << 20U;

/// Does not use the file size, which a pipe does not have.
std::string read_up_to(std::istream& in, std::size_t most) {
  std::string text;
  std::array<char, 65'536> piece{};
  while (text.size() < most && in) {
    in.read(piece.data(), static_cast<std::streamsize>(std::min(piece.size(), most - text.size())));
    text.append(piece.data(), static_cast<std::size_t>(in.gcount()));
  }
  return text;
}

}  // namespace

Database read_dbc(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, ignored))
    throw DbcError(file.string() + ": cannot be read; name a DBC file that exists");
  const std::string text = read_up_to(in, largest_file + 1);
  if (text.size() > largest_file)
    throw DbcError(file.string() + ": is larger than 16 MiB; name a DBC file");
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
