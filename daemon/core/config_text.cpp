// Values that the configuration and the command line share: the model and a pose.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/core/config.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::daemon {

estimator::Model parse_model(std::string_view name) {
  const auto* const found = std::ranges::find(estimator::model_names, name);
  if (found == estimator::model_names.end())
    throw std::invalid_argument(
        fmt::format("\"{}\" is not a model of this version; the models are: {}", name,
                    fmt::join(estimator::model_names, ", ")));
  return static_cast<estimator::Model>(found - estimator::model_names.begin());
}

std::string_view name_of(estimator::Model model) {
  return estimator::model_names[static_cast<std::size_t>(model)];
}

estimator::Pose2 parse_pose(std::string_view text) {
  std::array<double, 3> pose{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const auto [next, error] = std::from_chars(at, end, pose[i]);
    const bool last = i + 1 == pose.size();
    const bool ends_well = last ? next == end : (next != end && *next == ',');
    if (error != std::errc{} || !std::isfinite(pose[i]) || !ends_well)
      throw std::invalid_argument(fmt::format(
          "\"{}\" is not a pose; write x,y,yaw in metres and radians, as 1.5,-0.2,3.14", text));
    at = next + (last ? 0 : 1);
  }
  const estimator::Pose2 result{pose[0], pose[1], pose[2]};
  if (!estimator::is_possible(result))
    throw std::invalid_argument(fmt::format("\"{}\" {}", text, pose_too_far));
  return result;
}

}  // namespace odomd::daemon
