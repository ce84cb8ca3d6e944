// The schemas of the messages in an MCAP file, as JSON schema. Foxglove recognises its own schemas
// by their names (https://docs.foxglove.dev/docs/sdk/schemas): a 3D panel shows messages only if
// both name and structure match.
#pragma once

#include <span>
#include <string>

#include "tools/drive_files/pose_fields.hpp"

namespace odomd::tools {

[[nodiscard]] std::string pose_in_frame_schema();     ///< foxglove.PoseInFrame
[[nodiscard]] std::string frame_transforms_schema();  ///< foxglove.FrameTransforms

/// odomd.Pose: a timestamp, the fields under their paths, mode_name if there is a mode.
[[nodiscard]] std::string pose_schema(std::span<const PoseField* const> fields);

/// A timestamp and named numbers.
[[nodiscard]] std::string numbers_schema(const std::string& title,
                                         std::span<const std::string_view> names);

}  // namespace odomd::tools
