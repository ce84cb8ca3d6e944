// The path of a value in a TOML file.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace odomd::tools {

/// "can.signals.yaw_rate.sigma", "camera.lever_arm[2]", "can.e2e.\"a.b\".max": names, and at the
/// end perhaps an element of a list.
struct TomlPath {
  std::vector<std::string> names;
  std::optional<std::size_t> element;
};

/// Throws std::invalid_argument for an invalid path.
[[nodiscard]] TomlPath parse_toml_path(const std::string& key);

/// "[vehicle] mass", as the configuration's own errors have it.
[[nodiscard]] std::string shown(const TomlPath& path);

}  // namespace odomd::tools
