// The configuration and its databases as a recording stores them: in one folder, so that they can
// be used on another machine.
#pragma once

#include <string>
#include <vector>

#include "daemon/core/config.hpp"

namespace odomd::daemon {

struct RecordingFile {
  std::string name;  ///< in the folder, without any directory
  std::string text;
};

/// The configuration's text first, as "car.toml", with [can] dbc pointing to the copies; then the
/// databases under their own file names. Comments are kept. Throws std::runtime_error when a
/// database can no longer be read.
[[nodiscard]] std::vector<RecordingFile> recording_files(const Config& config);

}  // namespace odomd::daemon
