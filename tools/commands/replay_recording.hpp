// odom replay --recording.
#pragma once

#include <string>

namespace odomd::tools {

struct RecordingOptions {
  std::string folder;
  std::string out;  ///< pose file, "-", or empty: none
  bool verify = false;
  bool json = false;
};

/// Throws std::runtime_error if verifying finds a difference.
void replay_recording(const RecordingOptions& options);

}  // namespace odomd::tools
