// Converts the text of a DBC to UTF-8 before it is split into tokens.
#pragma once

#include <string>
#include <string_view>

namespace odomd::can {

/// UTF-8 without a byte order mark. Text that is not valid UTF-8 is read as Windows-1252, the
/// superset of Latin-1 that DBC editors write. Never fails.
[[nodiscard]] std::string to_utf8(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

}  // namespace odomd::can
