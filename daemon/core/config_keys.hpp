// The table of the configuration's keys, one row each. The reader, odom identify (lists, groups of
// values) and the test of docs/configuration.md go through it. It lacks the keys of [can] that
// depend on each other: sources, databases, roles and protections.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/core/config.hpp"

namespace odomd::daemon {

/// The allowed range of a number. The text completes "it must be ...".
struct Range {
  double lowest = -std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::max();
  bool lowest_included = true;
  std::string_view text = "a finite number";

  [[nodiscard]] bool contains(double value) const;
};
inline constexpr Range any_number{};
inline constexpr Range positive{0.0, any_number.highest, false, "greater than 0"};

/// A name from a list, in upper or lower case.
struct Choice {
  std::span<const std::string_view> names;
  void (*set)(Config&, std::size_t);
};

template <typename Value>
using Member = Value& (*)(Config&);

struct ConfigKey {
  std::string_view table;  ///< "vehicle"
  std::string_view name;   ///< "mass"
  /// The member it sets: an int64 holds nanoseconds, given in seconds; a uint32 is a file mode.
  std::variant<Member<double>, Member<std::optional<double>>, Member<std::array<double, 2>>,
               Member<std::array<double, 3>>, Member<std::optional<std::array<double, 3>>>,
               Member<std::optional<estimator::Pose2>>, Member<int>, Member<std::int64_t>,
               Member<std::uint32_t>, Member<std::string>, Member<std::filesystem::path>,
               Member<estimator::Model>, Choice>
      member;
  Range range = any_number;
  std::string_view group = {};  ///< shared by values that are identified together
  /// Returns what is wrong with a value of the right type and range, or an empty text.
  std::string_view (*problem)(const Config&) = nullptr;
};

/// The table begins with the numbers of a car; a file gives all of them or none.
inline constexpr std::size_t numbers_of_a_car = 7;

/// The rows, grouped by table, in the order in which the reader reports errors.
[[nodiscard]] std::span<const ConfigKey> config_keys();

/// The row of "vehicle.mass" or "camera.lever_arm[2]"; null if there is none.
[[nodiscard]] const ConfigKey* config_key(std::string_view path);

}  // namespace odomd::daemon
