#include "tools/fault/stream_faults.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace odomd::fault {
namespace {

using estimator::CameraPose;

constexpr std::uint64_t outlier_every = 5;

std::int64_t nanoseconds(double seconds) {
  return std::llround(seconds * 1e9);
}

}  // namespace

CameraFault::CameraFault(const Fault& fault, ActiveTime span)
    : fault_(fault), span_(span), random_(fault.seed, name_of(fault.kind)) {}

void CameraFault::take(const CameraPose& pose, std::vector<CameraPose>& out) {
  release(pose.arrival_ns, out);
  if (!span_.holds(pose.arrival_ns)) {
    if (pose.arrival_ns < span_.begin_ns) latest_ = pose;
    out.push_back(pose);
    return;
  }
  const std::uint64_t number = poses_++;
  switch (fault_.kind.act) {
    case Act::lost:
      return;
    case Act::delayed:
      held_.push_back(pose);
      held_.back().arrival_ns += nanoseconds(fault_.magnitude);
      return;
    case Act::duplicated:
      out.insert(out.end(), 2, pose);
      return;
    default:
      out.push_back(changed(pose, number));
  }
}

void CameraFault::release(std::int64_t now_ns, std::vector<CameraPose>& out) {
  std::size_t due = 0;
  while (due < held_.size() && held_[due].arrival_ns <= now_ns) out.push_back(held_[due++]);
  held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(due));
}

void CameraFault::add_noise(CameraPose& pose, double sigmas) {
  pose.x += sigmas * pose.sigma_x * random_.normal();
  pose.y += sigmas * pose.sigma_y * random_.normal();
  pose.yaw += sigmas * pose.sigma_yaw * random_.normal();
}

CameraPose CameraFault::changed(const CameraPose& pose, std::uint64_t number) {
  CameraPose result = pose;
  const double size = fault_.magnitude;
  switch (fault_.kind.act) {
    case Act::frozen:
    case Act::frozen_noisy:
      if (!latest_) latest_ = pose;
      result.x = latest_->x;
      result.y = latest_->y;
      result.yaw = latest_->yaw;
      if (fault_.kind.act == Act::frozen_noisy) add_noise(result, size);
      break;
    case Act::noisy:
      add_noise(result, size);
      break;
    case Act::moved:
      result.x += size;
      break;
    case Act::turned:
      result.yaw += size;
      break;
    case Act::drifting:
      result.x += size * static_cast<double>(pose.arrival_ns - span_.begin_ns) * 1e-9;
      break;
    case Act::mirrored:
      result.y = -result.y;
      result.yaw = -result.yaw;
      break;
    case Act::outliers:
      if (number % outlier_every == 0) {
        const double direction = random_.uniform(0.0, 2.0 * std::numbers::pi);
        result.x += size * std::cos(direction);
        result.y += size * std::sin(direction);
      }
      break;
    case Act::early:
      result.capture_ns -= nanoseconds(size);
      break;
    case Act::late:
      result.capture_ns += nanoseconds(size);
      break;
    case Act::skewed:
      result.capture_ns -=
          nanoseconds(size * static_cast<double>(pose.arrival_ns - span_.begin_ns) * 1e-9);
      break;
    case Act::mixed: {
      // The pictures' numbers: 0, 1, 2, 1, 4, 3, 6, 5, ...
      const CameraPose before = std::exchange(shown_[0], std::exchange(shown_[1], pose));
      if (number % 2 == 1 && number > 1) {
        result.x = before.x;
        result.y = before.y;
        result.yaw = before.yaw;
      }
      break;
    }
    case Act::vague:
      result.sigma_x *= size;
      result.sigma_y *= size;
      result.sigma_yaw *= size;
      break;
    default:
      break;
  }
  return result;
}

}  // namespace odomd::fault
