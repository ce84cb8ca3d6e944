#include "estimator/integrity/source_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/settings.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/admission.hpp"
#include "estimator/integrity/monitor/sources.hpp"

namespace odomd::estimator {
namespace {

using monitor::Contradicted;
using monitor::Interval;
using monitor::look_every_ns;
using monitor::Testimony;

// On top of twice the slowest source's cycle; the camera's motion is a mean over some time.
constexpr double window_s = 0.1;
constexpr double camera_window_s = 0.2;
constexpr double wheel_window_s = 0.04;

// So long evidence must last before a flag is raised, and be gone before it is lowered.
constexpr double frozen_after_s = 0.06;
constexpr double drifting_after_s = 0.12;
constexpr double slipping_after_s = 0.06;
constexpr double calm_s = 1.0;
constexpr int bad_in_a_row = 2;

// A stamp so far ahead of its arrival is none: all that comes before that time would be old.
constexpr std::int64_t future_ns = 10'000'000;

// A value repeats when so many samples over so long have had the same bits.
constexpr int repeats_samples = 4;
constexpr double repeats_s = 0.15;

}  // namespace

SourceMonitor::SourceMonitor(const Vehicle& vehicle,
                             const std::array<double, source_count>& sigma) noexcept
    : car_(vehicle) {
  for (std::size_t i = 0; i < source_count; ++i) {
    sigma_[i] = sigma[i] > 0.0 ? sigma[i] : default_sigma[i];
  }
}

void SourceMonitor::bad_sample(Signal& signal, SourceFlag kind, std::int64_t time_ns) noexcept {
  signal.bad = std::min(signal.bad + 1, bad_in_a_row);
  if (signal.bad == bad_in_a_row) {
    signal.flag = kind;
    signal.evidence_ns = time_ns;
  }
}

void SourceMonitor::heard(Signal& signal, std::int64_t taken_ns, std::int64_t heard_ns,
                          bool same) noexcept {
  constexpr double longest_cycle_s = 0.3;
  if (signal.seen) {
    const double cycle_s = std::min(seconds_between(signal.taken_ns, taken_ns), longest_cycle_s);
    signal.cycle_s += (signal.cycle_s > 0.0 ? 0.1 : 1.0) * (cycle_s - signal.cycle_s);
  }
  if (!signal.seen || !same) {
    signal.same = 0;
    signal.same_since_ns = taken_ns;
  }
  signal.same += 1;
  signal.seen = true;
  signal.bad = 0;
  signal.taken_ns = taken_ns;
  signal.heard_ns = heard_ns;
}

void SourceMonitor::take(const Measurement& sample) noexcept {
  const std::optional<Verdict> refused = refusal(sample);
  if (refused == Verdict::source_off) {
    return;
  }
  Signal& signal = signals_[index_of(sample.source)];
  const std::int64_t heard_ns = sample.arrival_ns != 0 ? sample.arrival_ns : sample.time_ns;
  if (refused) {
    bad_sample(signal,
               refused == Verdict::gated ? SourceFlag::out_of_range : SourceFlag::non_finite,
               heard_ns);
    return;
  }
  if (signal.seen && sample.time_ns <= signal.taken_ns) {
    return;
  }
  if (ns_between(heard_ns, sample.time_ns) > future_ns) {
    return;
  }
  heard(signal, sample.time_ns, heard_ns, sample.value == signal.value);
  signal.value = sample.value;
  wheels_know_sign_ = wheels_know_sign_ || (is_wheel(sample.source) && sample.value < 0.0);
}

void SourceMonitor::take(const CameraPose& camera) noexcept {
  Signal& signal = this->signal(Source::camera);
  const std::int64_t heard_ns = camera.arrival_ns != 0 ? camera.arrival_ns : camera.capture_ns;
  if (!is_usable(camera)) {
    take_unusable_pose();
    return;
  }
  if (signal.seen && camera.capture_ns <= signal.taken_ns) {
    return;
  }
  if (ns_between(heard_ns, camera.capture_ns) > future_ns) {
    return;
  }
  const SeenPose& before = newest_pose();
  const bool same =
      pose_count_ > 0 && camera.x == before.x && camera.y == before.y && camera.yaw == before.yaw;
  heard(signal, camera.capture_ns, heard_ns, same);
  usable_pose_ = true;
  if (!same) {
    way_since_pose_ = 0.0;
    turn_since_pose_ = 0.0;
  }
  poses_[pose_count_ % poses_.size()] = {
      camera.capture_ns, camera.x, camera.y, camera.yaw, std::max(camera.sigma_x, camera.sigma_y),
      camera.sigma_yaw};
  ++pose_count_;
}

bool SourceMonitor::alive(Source source) const noexcept {
  const Signal& s = signal(source);
  return s.seen && s.cycle_s > 0.0 && s.bad == 0 &&
         seconds_between(s.heard_ns, now_ns_) <= 3.5 * s.cycle_s + 0.01;
}

bool SourceMonitor::repeats(Source source) const noexcept {
  const Signal& s = signal(source);
  return s.same >= repeats_samples && seconds_between(s.same_since_ns, s.taken_ns) >= repeats_s;
}

void SourceMonitor::step(std::int64_t tick_ns) noexcept {
  now_ns_ = tick_ns;
  if (!usable_pose_) {
    for (int i = std::min(unusable_poses_, bad_in_a_row); i > 0; --i) {
      bad_sample(signal(Source::camera), SourceFlag::non_finite, tick_ns);
    }
  }
  unusable_poses_ = 0;
  usable_pose_ = false;
  if (looked_ && ns_between(looked_ns_, tick_ns) < look_every_ns) {
    return;
  }
  const double dt = looked_ ? std::min(seconds_between(looked_ns_, tick_ns), 0.1) : 0.0;
  looked_ = true;
  looked_ns_ = tick_ns;
  evidence_.fill(SourceFlag::ok);
  look();

  double slowest_s = 0.0;
  for (std::size_t i = 0; i < source_count; ++i) {
    const auto source = static_cast<Source>(i);
    if (source != Source::direction && source != Source::camera && alive(source)) {
      slowest_s = std::max(slowest_s, signals_[i].cycle_s);
    }
  }
  const auto rows_of = [&](double seconds) {
    const double rows = std::ceil((seconds + 2.0 * slowest_s) * ns_per_second / look_every_ns);
    return std::clamp(static_cast<std::size_t>(rows), std::size_t{2}, History::capacity - 1);
  };
  Testimony told = testimony({.wheels = rows_of(wheel_window_s),
                              .beside_camera = rows_of(camera_window_s),
                              .all = rows_of(window_s)});
  Contradicted found = contradicted(told);
  backwards_ = false;
  const bool told_direction = alive(Source::direction) && signal(Source::direction).value != 0.0;
  if (!wheels_know_sign_ && !told_direction) {
    const Testimony mirrored = told.mirrored();
    const Contradicted otherwise = contradicted(mirrored);
    backwards_ = goes_backwards(told, found.count(), otherwise.count());
    if (backwards_) {
      told = mirrored;
      found = otherwise;
    }
  }
  blame_wheels(told, found);
  blame_turns(told, found);
  if (found.lengthwise) {
    blame_lengthwise(told);
  }

  const Interval& v = history_.at(0)[speed];
  const Interval& turn = history_.at(0)[turn_by_gyro];
  way_since_pose_ += v.known() ? std::abs(v.low) * dt : 0.0;
  turn_since_pose_ += turn.known() && v.known() && v.low != 0.0 ? turn.low * dt : 0.0;
  watch_camera_pose();
  settle();
}

void SourceMonitor::suspect(Source source, SourceFlag kind) noexcept {
  SourceFlag& evidence = evidence_[index_of(source)];
  if (evidence == SourceFlag::ok) {
    evidence = kind;
  }
}

/// Evidence that lasts becomes a flag; a flag goes when there was none for a while.
void SourceMonitor::settle() noexcept {
  wheels_slip_ = false;
  for (std::size_t i = 0; i < source_count; ++i) {
    Signal& s = signals_[i];
    const SourceFlag evidence = evidence_[i];
    const bool still_frozen = s.flag == SourceFlag::frozen && s.same >= repeats_samples;
    if (evidence == SourceFlag::ok) {
      s.suspected = SourceFlag::ok;
      if (still_frozen) {
        s.evidence_ns = now_ns_;
      } else if (s.flag != SourceFlag::ok && seconds_between(s.evidence_ns, now_ns_) >= calm_s) {
        s.flag = SourceFlag::ok;
      }
    } else {
      if (s.suspected == SourceFlag::ok) {
        s.suspected_since_ns = now_ns_;
      }
      s.suspected = evidence;
      const double after_s = evidence == SourceFlag::frozen     ? frozen_after_s
                             : evidence == SourceFlag::slipping ? slipping_after_s
                                                                : drifting_after_s;
      if (s.flag != SourceFlag::ok || seconds_between(s.suspected_since_ns, now_ns_) >= after_s) {
        if (s.flag == SourceFlag::ok || evidence == SourceFlag::frozen) {
          s.flag = evidence;
        }
        s.evidence_ns = now_ns_;
      }
    }
    if (is_wheel(static_cast<Source>(i)) &&
        (s.flag != SourceFlag::ok || evidence != SourceFlag::ok)) {
      wheels_slip_ = true;
    }
  }
}

}  // namespace odomd::estimator
