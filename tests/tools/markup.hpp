// Whether a text is well-formed XML, as far as our own pages and pictures need it: tags that close
// in order, attributes in double quotes, no bare "&" or "<".
#pragma once

#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::tools {

inline bool has_bare_ampersand(std::string_view text) {
  for (std::size_t i = 0; (i = text.find('&', i)) != std::string_view::npos; ++i) {
    const std::size_t end = text.find(';', i);
    if (end == std::string_view::npos || end == i + 1 || end - i > 8) return true;
  }
  return false;
}

/// The name of a tag, from the text between < and >; nothing if that is malformed.
inline std::optional<std::string> tag_name(std::string_view inside) {
  const auto is_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == ':';
  };
  const auto take_name = [&] {
    std::size_t length = 0;
    while (length < inside.size() && is_name(inside[length])) ++length;
    const std::string name{inside.substr(0, length)};
    inside.remove_prefix(length);
    return name;
  };
  const std::string name = take_name();
  if (name.empty()) return std::nullopt;
  for (;;) {
    const std::size_t blank = inside.find_first_not_of(" \n");
    if (blank == std::string_view::npos) return name;
    if (blank == 0) return std::nullopt;
    inside.remove_prefix(blank);
    if (take_name().empty() || !inside.starts_with("=\"")) return std::nullopt;
    const std::size_t end = inside.find('"', 2);
    if (end == std::string_view::npos ||
        inside.substr(2, end - 2).find('<') != std::string_view::npos)
      return std::nullopt;
    inside.remove_prefix(end + 1);
  }
}

/// The first error, with the text around it; empty if there is none.
inline std::string markup_fault(std::string_view text) {
  const auto around = [&text](std::size_t at) {
    return " at \"" + std::string{text.substr(at, 60)} + '"';
  };
  std::vector<std::string> open;
  std::size_t at = 0;
  for (;;) {
    const std::size_t next = text.find('<', at);
    const std::string_view words = text.substr(at, next - at);
    if (has_bare_ampersand(words)) return "a bare &" + around(at);
    if (open.empty() && words.find_first_not_of(" \n") != std::string_view::npos)
      return "words outside" + around(at);
    if (next == std::string_view::npos) break;
    const std::size_t end = text.find('>', next);
    if (end == std::string_view::npos) return "a tag without end" + around(next);
    std::string_view inside = text.substr(next + 1, end - next - 1);
    at = end + 1;
    if (inside == "!DOCTYPE html" && open.empty()) continue;
    if (has_bare_ampersand(inside)) return "a bare & in a tag" + around(next);
    const bool closes = inside.starts_with('/');
    const bool alone = inside.ends_with('/');
    if (closes) inside.remove_prefix(1);
    if (alone) inside.remove_suffix(1);
    const auto name = tag_name(inside);
    if (!name) return "no tag" + around(next);
    if (closes) {
      if (open.empty() || open.back() != *name) return "closes what is not open" + around(next);
      open.pop_back();
    } else if (!alone) {
      open.push_back(*name);
    }
  }
  return open.empty() ? "" : '"' + open.back() + "\" is not closed";
}

}  // namespace odomd::tools
