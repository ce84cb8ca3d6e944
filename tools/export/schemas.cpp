#include "tools/export/schemas.hpp"

#include <nlohmann/json.hpp>

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;

Json number() {
  return {{"type", "number"}};
}
Json text() {
  return {{"type", "string"}};
}

/// An object whose members are all required.
Json object(const std::string& title, Json properties) {
  Json required = Json::array();
  for (const auto& [name, ignored] : properties.items()) required.push_back(name);
  Json schema = Json::object();
  if (!title.empty()) schema["title"] = title;
  schema["type"] = "object";
  schema["properties"] = std::move(properties);
  schema["required"] = std::move(required);
  return schema;
}

Json time() {
  return object("time",
                {{"sec", {{"type", "integer"}, {"minimum", 0}}},
                 {"nsec", {{"type", "integer"}, {"minimum", 0}, {"maximum", 999'999'999}}}});
}
Json vector3() {
  return object("foxglove.Vector3", {{"x", number()}, {"y", number()}, {"z", number()}});
}
Json quaternion() {
  return object("foxglove.Quaternion",
                {{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
}

}  // namespace

std::string pose_in_frame_schema() {
  const Json pose =
      object("foxglove.Pose", {{"position", vector3()}, {"orientation", quaternion()}});
  return object("foxglove.PoseInFrame",
                {{"timestamp", time()}, {"frame_id", text()}, {"pose", pose}})
      .dump();
}

std::string frame_transforms_schema() {
  const Json transform = object("foxglove.FrameTransform", {{"timestamp", time()},
                                                            {"parent_frame_id", text()},
                                                            {"child_frame_id", text()},
                                                            {"translation", vector3()},
                                                            {"rotation", quaternion()}});
  return object("foxglove.FrameTransforms",
                {{"transforms", {{"type", "array"}, {"items", transform}}}})
      .dump();
}

std::string pose_schema(std::span<const PoseField* const> fields) {
  Json properties{{"timestamp", time()}};
  Json groups = Json::object();
  bool has_mode = false;
  for (const PoseField* field : fields) {
    const std::size_t slash = field->path.find('/');
    const std::string first{field->path.substr(0, slash)};
    if (slash == std::string_view::npos)
      properties[first] = number();
    else
      groups[first][std::string{field->path.substr(slash + 1)}] = number();
    has_mode = has_mode || field->path == mode_path;
  }
  for (const auto& [name, members] : groups.items()) properties[name] = object("", members);
  if (has_mode) properties["mode_name"] = text();
  return object("odomd.Pose", properties).dump();
}

std::string numbers_schema(const std::string& title, std::span<const std::string_view> names) {
  Json properties{{"timestamp", time()}};
  for (const std::string_view name : names) properties[std::string{name}] = number();
  return object(title, properties).dump();
}

}  // namespace odomd::tools
