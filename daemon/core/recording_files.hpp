// The configuration and its databases as a recording keeps them: side by side in one folder, so
// that they mean the same on another machine.
#pragma once

#include <string>
#include <vector>

#include "daemon/core/config.hpp"

namespace odomd::daemon {

struct RecordingFile {
  std::string name;  ///< in the folder, without any directory
  std::string text;
};

/// The configuration's text first, as "car.toml", its [can] dbc naming the copies; then the
/// databases under their own file names. Comments are kept. Throws std::runtime_error where a
/// database can no longer be read.
[[nodiscard]] std::vector<RecordingFile> recording_files(const Config& config);

}  // namespace odomd::daemon
