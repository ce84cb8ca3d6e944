// Whether each source tells the truth, judged by all others: sensors that measure the same motion
// are held against each other, whatever the filter believes. Derived in docs/model.md, "Source
// flags".
//
// A value; no heap, no clock. The order in which the samples of different sources come in within a
// look (20 ms) does not matter.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "estimator/common/measurement.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/integrity/monitor/interval.hpp"
#include "estimator/integrity/monitor/testimony.hpp"

namespace odomd::estimator {

enum class SourceFlag : std::uint8_t {
  ok,
  out_of_range,  ///< beyond what any car does (admission.hpp), twice in a row
  non_finite,    ///< NaN, infinity or an impossible sigma, twice in a row
  frozen,        ///< the same bits again and again, while the car has moved on
  drifting,      ///< two other sources or more, that agree, contradict it
  slipping,      ///< a wheel, an axle or the motor: it turns otherwise than the car moves
  timed_out,     ///< this and the next are for those who know the bus
  failed_protection,
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(SourceFlag::count)>
    source_flag_names{"ok",       "out_of_range", "non_finite", "frozen",
                      "drifting", "slipping",     "timed_out",  "failed_protection"};

class SourceMonitor {
 public:
  /// `sigma`: standard deviation of each source's samples, in the order of Source; 0: its default.
  SourceMonitor(const Vehicle& vehicle, const std::array<double, source_count>& sigma) noexcept;

  /// Every sample once, as it comes in; those that are older than the newest of their source, or
  /// from the future, count for nothing but their range.
  void take(const Measurement& sample) noexcept;
  void take(const CameraPose& camera) noexcept;

  /// A camera's message that is no pose: what else comes in within the tick counts more, whichever
  /// came first.
  void take_unusable_pose() noexcept { ++unusable_poses_; }

  /// Once a tick, in order of time.
  void step(std::int64_t tick_ns) noexcept;

  [[nodiscard]] SourceFlag flag(Source source) const noexcept {
    return signals_[static_cast<std::size_t>(source)].flag;
  }

 private:
  /// What is compared, in the columns of the history.
  enum Column : std::size_t {
    turn_by_gyro,  ///< ψ̇ [rad/s]
    turn_by_steering,
    turn_by_rear_wheels,
    turn_by_front_wheels,
    turn_by_camera,
    side_by_gyro,  ///< v ψ̇ [m/s²]
    side_by_steering,
    side_by_rear_wheels,
    side_felt,    ///< accel_y
    ahead_felt,   ///< accel_x
    speed,        ///< v_x [m/s], what the wheels agree on
    speed_rate,   ///< its derivative [m/s²]
    first_wheel,  ///< v_x by each of the six wheel sources
    speed_by_camera = first_wheel + 6,
    columns
  };
  using History = monitor::History<columns>;

  struct Signal {
    SourceFlag flag = SourceFlag::ok;
    SourceFlag suspected = SourceFlag::ok;  ///< not yet for long enough
    std::int64_t suspected_since_ns = 0;
    std::int64_t evidence_ns = 0;  ///< last time that the flag was deserved

    bool seen = false;
    int bad = 0;  ///< samples in a row that were no numbers or out of range
    double value = 0.0;
    double cycle_s = 0.0;            ///< mean time between two samples; 0: not known
    std::int64_t heard_ns = 0;       ///< arrival of the newest
    std::int64_t taken_ns = 0;       ///< its own time
    std::int64_t same_since_ns = 0;  ///< taken, the first of those with the newest's bits
    int same = 0;                    ///< samples with the bits of the newest, it included
  };

  struct SeenPose {
    std::int64_t time_ns = 0;
    double x = 0.0;
    double y = 0.0;
    double yaw = 0.0;
    double sigma = 0.0;
    double sigma_yaw = 0.0;
  };

  [[nodiscard]] Signal& signal(Source source) noexcept {
    return signals_[static_cast<std::size_t>(source)];
  }
  [[nodiscard]] const Signal& signal(Source source) const noexcept {
    return signals_[static_cast<std::size_t>(source)];
  }
  /// Of the camera; all zero before the first.
  [[nodiscard]] const SeenPose& newest_pose() const noexcept {
    return poses_[(pose_count_ + poses_.size() - 1) % poses_.size()];
  }
  [[nodiscard]] bool alive(Source source) const noexcept;
  [[nodiscard]] bool repeats(Source source) const noexcept;
  static void bad_sample(Signal& signal, SourceFlag kind, std::int64_t time_ns) noexcept;
  static void heard(Signal& signal, std::int64_t taken_ns, std::int64_t heard_ns,
                    bool same) noexcept;
  void look() noexcept;
  /// Rows of the history: over how long each is represented.
  struct Spans {
    std::size_t wheels;         ///< against each other
    std::size_t beside_camera;  ///< what is held against the camera
    std::size_t all;            ///< all else
  };
  [[nodiscard]] monitor::Testimony testimony(const Spans& spans) const noexcept;
  [[nodiscard]] monitor::Contradicted contradicted(const monitor::Testimony& told) const noexcept;
  [[nodiscard]] double lengthwise_error(const monitor::Testimony& told) const noexcept;
  bool goes_backwards(const monitor::Testimony& told, int ahead, int backwards) noexcept;
  void blame_wheels(const monitor::Testimony& told,
                    const monitor::Contradicted& contradicted) noexcept;
  void blame_turns(const monitor::Testimony& told,
                   const monitor::Contradicted& contradicted) noexcept;
  void blame_lengthwise(const monitor::Testimony& told) noexcept;
  void watch_camera_pose() noexcept;
  void suspect(Source source, SourceFlag kind) noexcept;
  void settle() noexcept;

  Vehicle car_;
  std::array<double, source_count> sigma_{};
  std::array<Signal, source_count> signals_{};
  std::array<SourceFlag, source_count> evidence_{};  ///< of the look at hand
  History history_;
  std::array<SeenPose, 16> poses_{};
  std::size_t pose_count_ = 0;     ///< ever taken
  int unusable_poses_ = 0;         ///< in this tick
  bool usable_pose_ = false;       ///< in this tick
  double way_since_pose_ = 0.0;    ///< [m] driven since the camera's pose last changed
  double turn_since_pose_ = 0.0;   ///< [rad]
  bool wheels_know_sign_ = false;  ///< a speed was negative
  bool wheels_slip_ = false;
  double sideways_ = 0.0;   ///< [m/s] that the car would have come to move if the speed were right
  int ahead_rather_ = 0;    ///< contradictions fewer since the last halt if it goes ahead
  bool backwards_ = false;  ///< wheels that know no sign turn backwards
  std::int64_t now_ns_ = 0;
  std::int64_t looked_ns_ = 0;
  bool looked_ = false;
};

}  // namespace odomd::estimator
