// The kinds of faults as people and programs read them: odom fault --list.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace odomd::fault {

/// What can fail, in which ways, and how large each fault is unless it is said.
[[nodiscard]] std::string kinds_text();
/// An array with an object for every kind: kind, part, what, size, unit, sources.
[[nodiscard]] nlohmann::ordered_json kinds_json();

}  // namespace odomd::fault
