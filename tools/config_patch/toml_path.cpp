#include "tools/config_patch/toml_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <system_error>

#include "daemon/core/toml_depth.hpp"
#include "tools/cli/csv.hpp"
#include "tools/config_patch/toml_lines.hpp"

namespace odomd::tools {

TomlPath parse_toml_path(const std::string& key) {
  const auto no_key = [&] { throw std::invalid_argument(tools::quoted(key) + " is not a key"); };
  TomlPath path;
  std::size_t at = 0;
  while (true) {
    std::string name;
    if (at < key.size() && key[at] == '"') {
      const std::size_t closing = key.find('"', at + 1);
      if (closing == std::string::npos) no_key();
      name = key.substr(at + 1, closing - at - 1);
      at = closing + 1;
    } else {
      const std::size_t end = std::min(key.find_first_of(".[", at), key.size());
      name = key.substr(at, end - at);
      at = end;
    }
    if (name.empty() || path.names.size() == daemon::deepest_key) no_key();
    path.names.push_back(std::move(name));
    if (at == key.size() || key[at] != '.') break;
    ++at;
  }
  if (at < key.size()) {
    const char* const end = key.data() + key.size();
    std::size_t index = 0;
    const auto [after, error] = std::from_chars(key.data() + at + 1, end, index);
    if (key[at] != '[' || error != std::errc{} || after + 1 != end || *after != ']') no_key();
    path.element = index;
  }
  return path;
}

std::string shown(const TomlPath& path) {
  std::string table;
  for (std::size_t i = 0; i + 1 < path.names.size(); ++i)
    table += (i == 0 ? "" : ".") + toml_key(path.names[i]);
  std::string text = table.empty() ? "" : "[" + table + "] ";
  text += toml_key(path.names.back());
  if (path.element) text += fmt::format("[{}]", *path.element);
  return text;
}

}  // namespace odomd::tools
