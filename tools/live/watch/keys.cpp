#include "tools/live/watch/keys.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace odomd::watch {
namespace {

// After "ESC [" or "ESC O".
constexpr std::array sequences{std::pair{std::string_view{"A"}, Key::up},
                               std::pair{std::string_view{"B"}, Key::down},
                               std::pair{std::string_view{"5~"}, Key::page_up},
                               std::pair{std::string_view{"6~"}, Key::page_down},
                               std::pair{std::string_view{"H"}, Key::home},
                               std::pair{std::string_view{"1~"}, Key::home},
                               std::pair{std::string_view{"F"}, Key::end},
                               std::pair{std::string_view{"4~"}, Key::end}};

constexpr std::array letters{
    std::pair{'q', Key::quit},  std::pair{'Q', Key::quit},  std::pair{'p', Key::pause},
    std::pair{'P', Key::pause}, std::pair{' ', Key::pause}, std::pair{'k', Key::up},
    std::pair{'j', Key::down},  std::pair{'g', Key::home},  std::pair{'G', Key::end}};

bool ends_sequence(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '~';
}

}  // namespace

std::vector<Key> keys_in(std::string_view bytes) {
  std::vector<Key> keys;
  const auto take = [&keys](const auto& table, const auto& pressed) {
    const auto* const found =
        std::find_if(table.begin(), table.end(),
                     [&pressed](const auto& entry) { return entry.first == pressed; });
    if (found != table.end()) keys.push_back(found->second);
  };
  while (!bytes.empty()) {
    const bool sequence =
        bytes.size() > 1 && bytes[0] == '\x1b' && (bytes[1] == '[' || bytes[1] == 'O');
    if (!sequence) {
      take(letters, bytes.front());
      bytes.remove_prefix(1);
      continue;
    }
    bytes.remove_prefix(2);
    const auto* const last = std::find_if(bytes.begin(), bytes.end(), ends_sequence);
    const auto length = static_cast<std::size_t>(last - bytes.begin());
    take(sequences, bytes.substr(0, length + 1));
    bytes.remove_prefix(std::min(bytes.size(), length + 1));
  }
  return keys;
}

}  // namespace odomd::watch
