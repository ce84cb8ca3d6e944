// The kinds of faults as text and JSON: odom fault --list.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace odomd::fault {

/// The parts that can fail, their ways to fail, and the default size of each fault.
[[nodiscard]] std::string kinds_text();
/// An array with an object for every kind: kind, part, what, size, unit, sources.
[[nodiscard]] nlohmann::ordered_json kinds_json();

}  // namespace odomd::fault
