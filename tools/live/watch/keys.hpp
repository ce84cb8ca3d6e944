// What was pressed: bytes of a terminal in, keys out.
#pragma once

#include <string_view>
#include <vector>

namespace odomd::watch {

enum class Key { quit, pause, up, down, page_up, page_down, home, end };

/// The keys in what was read at once; others, and sequences that are not known, are passed over.
[[nodiscard]] std::vector<Key> keys_in(std::string_view bytes);

}  // namespace odomd::watch
