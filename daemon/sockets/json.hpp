// Writes a JSON document piece by piece into a string. Supports only what the status needs.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace odomd::daemon {

class JsonWriter {
 public:
  void begin_object() { open('{'); }
  void begin_object(std::string_view key) { name(key), open('{'); }
  void end_object() { close('}'); }
  void begin_array(std::string_view key) { name(key), open('['); }
  void end_array() { close(']'); }

  template <typename T>
  void member(std::string_view key, const T& value) {
    name(key);
    element(value);
  }

  /// A text, a number, true or false, or null for an empty optional and for NaN or infinity, which
  /// JSON does not have. Numbers have the shortest text that reads back as the same value.
  template <typename T>
  void element(const T& value) {
    separate();
    if constexpr (std::convertible_to<T, std::string_view>) {
      quote(value);
    } else if constexpr (std::floating_point<T>) {
      if (std::isfinite(value))
        fmt::format_to(std::back_inserter(text_), "{}", value);
      else
        text_ += "null";
    } else {
      fmt::format_to(std::back_inserter(text_), "{}", value);
    }
  }
  template <typename T>
  void element(const std::optional<T>& value) {
    if (value) return element(*value);
    element(NAN);
  }

  /// A list of elements.
  void list(std::string_view key, const auto& values) {
    begin_array(key);
    for (const auto& value : values) element(value);
    end_array();
  }
  /// An object with a counter for each name.
  void counts(std::string_view key, const auto& names, const auto& counters) {
    begin_object(key);
    for (std::size_t i = 0; i < std::size(counters); ++i) member(names[i], counters[i].get());
    end_object();
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void separate() {
    if (!first_) text_ += ',';
    first_ = false;
  }
  void open(char bracket) {
    separate();
    text_ += bracket;
    first_ = true;
  }
  void close(char bracket) {
    text_ += bracket;
    first_ = false;
  }
  void name(std::string_view key) {
    separate();
    quote(key);
    text_ += ':';
    first_ = true;  // no comma between a key and its value
  }
  /// Non-ASCII bytes are treated as Latin-1, so that the document is valid whatever the names of
  /// buses contain.
  void quote(std::string_view text) {
    text_ += '"';
    for (const char c : text) {
      const auto code = static_cast<unsigned char>(c);
      if (c == '"' || c == '\\') {
        text_ += '\\';
        text_ += c;
      } else if (code < 0x20 || code > 0x7E) {
        fmt::format_to(std::back_inserter(text_), "\\u{:04x}", code);
      } else {
        text_ += c;
      }
    }
    text_ += '"';
  }

  std::string text_;
  bool first_ = true;
};

}  // namespace odomd::daemon
