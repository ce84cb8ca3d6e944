// Reads databases from files, and looks up messages by name.
#include "can_protocol/dbc/dbc.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "base/input_file.hpp"
#include "can_protocol/dbc/lexer.hpp"

namespace odomd::can {
namespace {

/// Databases of production cars are a tenth of this size.
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

template <typename Named>
const Named* find_named(const std::vector<Named>& all, std::string_view name) {
  auto found = std::ranges::find(all, name, &Named::name);
  if (found == all.end() && !name.empty()) found = std::ranges::find(all, name, &Named::short_name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

Database read_dbc(const std::filesystem::path& file) {
  if (const std::string problem = problem_with_input(file); !problem.empty())
    throw DbcError(file.string() + ": " + problem);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw DbcError(file.string() + ": cannot be read; name a DBC file that exists");
  const std::string text = read_up_to(in, largest_file + 1);
  if (text.size() > largest_file)
    throw DbcError(file.string() + ": is larger than 16 MiB; name a DBC file");
  if (text.empty()) throw DbcError(file.string() + ": empty; name a DBC file with messages (BO_)");
  Database database = parse_dbc(text, file.string());
  if (database.messages.empty())
    throw DbcError(database.warnings.empty()
                       ? file.string() + ": no message (BO_) in it; name a DBC file"
                       : describe(database, database.warnings.front()) +
                             " (and no other message is left)");
  return database;
}

std::string describe(const Database& database, const Warning& warning) {
  return at_line(database.file, warning.line, warning.text);
}

const Message* find_message(const Database& database, std::string_view name) {
  return find_named(database.messages, name);
}

const Signal* find_signal(const Message& message, std::string_view name) {
  return find_named(message.signals, name);
}

}  // namespace odomd::can
