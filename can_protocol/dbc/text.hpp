// The text of a DBC before it is cut into tokens: the character sets that such files come in.
#pragma once

#include <string>
#include <string_view>

namespace odomd::can {

/// UTF-8 without a byte order mark. Text that is not valid UTF-8 is taken as Windows-1252, the
/// superset of Latin-1 that DBC editors write. Never fails.
[[nodiscard]] std::string to_utf8(std::string_view text);

}  // namespace odomd::can
