// The numbers of a pose with their names in plotting tools: one table for all outputs to such
// tools, so that live and recorded poses have the same names.
#pragma once

#include <odom/types.h>

#include <span>
#include <string>
#include <string_view>

namespace odomd::tools {

/// One number. SI units.
struct PoseField {
  std::string_view path;    ///< "map/x"; fields of one group are adjacent
  std::string_view column;  ///< in a pose file (pose_csv.hpp); empty: not in the file
  double (*value)(const odom_pose& pose, const odom_details& details);
  bool is_count = false;
};

[[nodiscard]] std::span<const PoseField> pose_fields();

/// The field `mode`, an odom_mode; a pose file contains its name.
inline constexpr std::string_view mode_path = "mode";

/// A JSON object of numbers and texts whose names may be paths of two parts; members of one group
/// must be added one after the other. A number that is not finite becomes null.
class NestedJson {
 public:
  explicit NestedJson(std::string& out);  ///< appends to it

  void number(std::string_view path, double value);
  void text(std::string_view path, std::string_view value);
  void raw(std::string_view path, std::string_view json);  ///< a value that is JSON already
  void end();

 private:
  void name(std::string_view path);

  std::string& out_;
  std::string group_;
  bool first_ = true;
};

}  // namespace odomd::tools
