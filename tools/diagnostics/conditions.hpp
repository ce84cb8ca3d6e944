// The bits of odom_pose.conditions: their names, and what they mean to people.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace odomd::tools {

struct Condition {
  std::uint32_t bit = 0;     ///< an ODOM_COND_
  std::string_view name;     ///< as in the status document
  std::string_view meaning;  ///< one clause
};

/// The conditions that are set, in the order of their bits.
[[nodiscard]] std::vector<Condition> conditions_in(std::uint32_t bits);

/// The condition with this name in the status document.
[[nodiscard]] std::optional<Condition> condition_named(std::string_view name);

}  // namespace odomd::tools
