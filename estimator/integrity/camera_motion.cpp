// docs/model.md, "Integrity".
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/pose.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/integrity.hpp"

namespace odomd::estimator {

using namespace integrity;

/// The motion between two poses, along the car. An outlier is left out. If the next pose is one
/// too, the map has jumped: the motion is then measured from there.
void Integrity::add(const CameraPose& pose) noexcept {
  constexpr double longest_pause_s = 0.5;
  constexpr double shortest_step_s = 0.005;  // several looks at one instant measure no speed
  SourceHistory& poses = observed_.sources[index_of(Source::camera)];
  const double dt = seconds_between(reference_pose_.capture_ns, pose.capture_ns);
  if (poses.seen() && (pose.capture_ns <= poses.time_ns || dt < shortest_step_s)) {
    return;
  }
  const std::array<double, 3> numbers{pose.x, pose.y, pose.yaw};
  const bool same = std::exchange(newest_pose_, numbers) == numbers;
  bool outlier = false;
  if (poses.seen() && dt < longest_pause_s) {
    const double turned = wrap_angle(pose.yaw - reference_pose_.yaw);
    const double middle = reference_pose_.yaw + 0.5 * turned;
    const double way = (pose.x - reference_pose_.x) * std::cos(middle) +
                       (pose.y - reference_pose_.y) * std::sin(middle);
    const double sigma = std::max(pose.sigma_x, pose.sigma_y);
    const auto is_motion = [&](const SourceHistory& recent, double by, double noise, double rate) {
      constexpr double sigmas = 8.0;
      const double most = sigmas * std::sqrt(observed_.errors.camera_noise_scale) * noise +
                          rate * (mean_s.front() + dt) * dt;
      return !recent.seen() || std::abs(by - recent.mean() * dt) <= most;
    };
    outlier = !is_motion(observed_.camera_speed, way, sigma, largest_accel) ||
              !is_motion(observed_.camera_yaw_rate, turned, pose.sigma_yaw, largest_yaw_accel);
    if (!outlier) {
      constexpr auto unfiltered = Prefilter::none;
      add_sample(observed_.camera_speed, pose.capture_ns, way / dt, sigma, same, unfiltered);
      add_sample(observed_.camera_yaw_rate, pose.capture_ns, turned / dt, pose.sigma_yaw, same,
                 unfiltered);
    }
  }
  const bool jumps = outlier && last_was_outlier_;
  last_was_outlier_ = outlier && !jumps;
  if (!last_was_outlier_) {
    reference_pose_ = pose;
  }
  add_sample(poses, pose.capture_ns, 0.0, 0.0, same);
  for (SourceHistory* const history :
       {&poses, &observed_.camera_speed, &observed_.camera_yaw_rate}) {
    history->arrival_ns = std::max(pose.arrival_ns, pose.capture_ns);
  }
}

}  // namespace odomd::estimator
