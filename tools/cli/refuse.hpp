// Errors about unusable input: what is wrong, and how to fix it.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace odomd::tools {

/// Throws std::invalid_argument with this text.
template <typename... Values>
[[noreturn]] void refuse(fmt::format_string<Values...> text, Values&&... values) {
  throw std::invalid_argument(fmt::format(text, std::forward<Values>(values)...));
}

}  // namespace odomd::tools
