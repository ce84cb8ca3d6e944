// The configuration and its databases as a recording stores them: in one folder.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "daemon/core/recording_wire.hpp"

namespace odomd::daemon {
namespace {

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in || text.empty())
    throw std::runtime_error(fmt::format("{}: cannot be read any more", file.string()));
  return text;
}

/// The offset of a position in the text. toml++ counts lines and characters from 1.
std::size_t offset_of(const std::string& text, const toml::source_position& position) {
  std::size_t at = 0;
  for (auto line = position.line; line > 1; --line) at = text.find('\n', at) + 1;
  for (auto column = position.column; column > 1 && at < text.size(); --column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  }
  return at;
}

std::string with_databases(const Config& config, const std::vector<std::string>& names) {
  const toml::table parsed = toml::parse(config.text);
  const toml::node* const value = parsed["can"]["dbc"].node();
  const std::size_t begin = offset_of(config.text, value->source().begin);
  const std::size_t end = offset_of(config.text, value->source().end);
  std::string text = config.text;
  text.replace(begin, end - begin, fmt::format("[\"{}\"]", fmt::join(names, "\", \"")));
  static_cast<void>(toml::parse(text));  // a recording with a damaged file would be lost
  return text;
}

/// The name of the file, made unique; characters that a TOML string would have to escape are
/// removed, and no name starts with a dot, which a recorder would reject.
std::string name_apart_from(const std::filesystem::path& file,
                            const std::vector<std::string>& others) {
  std::string own = file.filename().string();
  std::ranges::replace_if(
      own, [](char c) { return c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20; },
      '_');
  if (own.starts_with('.')) own.front() = '_';
  std::string name = own;
  for (int i = 2; name == "car.toml" || std::ranges::find(others, name) != others.end(); ++i)
    name = fmt::format("{}-{}", i, own);
  return name;
}

}  // namespace

std::vector<RecordingFile> recording_files(const Config& config) {
  std::vector<RecordingFile> files(1);
  std::vector<std::string> names;
  for (const auto& database : config.can.dbc) {
    names.push_back(name_apart_from(database, names));
    files.push_back({names.back(), contents(database)});
  }
  files.front() = {"car.toml", with_databases(config, names)};
  return files;
}

}  // namespace odomd::daemon
