// Writes a JSON document piece by piece into a string. Supports only what the status needs.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
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

  void element(std::string_view text) {
    separate();
    quote(text);
  }
  void element(const char* text) { element(std::string_view{text}); }
  void element(const std::string& text) { element(std::string_view{text}); }
  void element(bool value) {
    separate();
    text_ += value ? "true" : "false";
  }
  void element(std::integral auto value) {
    separate();
    fmt::format_to(std::back_inserter(text_), "{}", value);
  }
  /// The shortest text that reads back as the same value; null if JSON has no such number.
  void element(std::floating_point auto value) {
    separate();
    if (std::isfinite(value)) {
      fmt::format_to(std::back_inserter(text_), "{}", value);
    } else {
      text_ += "null";
    }
  }

  /// null if `value` is empty.
  template <typename T>
  void element(const std::optional<T>& value) {
    if (value) return element(*value);
    separate();
    text_ += "null";
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
