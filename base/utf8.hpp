// The encoding of external text: the characters of UTF-8, and its conversion from other encodings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace odomd {

struct Character {
  std::uint32_t code = 0;
  std::size_t length = 0;  ///< bytes; 0: not UTF-8
};

/// The character that begins at this byte; `at` is less than the text's size.
[[nodiscard]] Character character_at(std::string_view text, std::size_t at);

/// Whether a byte continues a character of UTF-8.
[[nodiscard]] bool is_continuation(char byte);

[[nodiscard]] bool is_utf8(std::string_view text);

/// UTF-8 without a byte order mark. Text that is not valid UTF-8 is read as Windows-1252, the
/// superset of Latin-1 that DBC editors and spreadsheets write. Never fails.
[[nodiscard]] std::string to_utf8(std::string_view text);

}  // namespace odomd
