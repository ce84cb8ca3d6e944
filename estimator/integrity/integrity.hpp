// Fault detection and isolation: compares all sources with their consensus on the motion of the
// car. If they contradict it, the fewest sources whose absence resolves this are at fault.
//
// docs/model.md, "Integrity".
//
// A value; no heap, no clock.
#pragma once

#include <array>
#include <cstdint>

#include "estimator/common/measurement.hpp"
#include "estimator/integrity/camera_consistency.hpp"
#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/equations.hpp"

namespace odomd::estimator {

class Integrity {
 public:
  /// Adds a sample of one of the car's own sensors, newer than the last of its source. A wheel
  /// speed has the sign of the direction, if that is measured. `arrival_ns` 0: the sample arrived
  /// when it was taken.
  void add(Source source, std::int64_t time_ns, double value, double sigma,
           std::int64_t arrival_ns = 0) noexcept;
  /// Forgets the samples of a source that has stopped sending.
  void forget(Source source) noexcept { observed_.sources[index_of(source)] = {}; }
  void add(const CameraPose& pose) noexcept;
  /// Adds the innovation of a camera pose and its variances (x, y, yaw), fused or not. Call it for
  /// every pose that is compared with the filter.
  void add_camera_innovation(const std::array<double, 3>& innovation,
                             const std::array<double, 3>& variance) noexcept {
    camera_innovations_.add(innovation, variance);
  }

  /// Compares the sources with each other; at most once in 20 ms.
  void check(const integrity::Sensors& sensors, std::int64_t now_ns,
             const integrity::SensorErrors& errors = {}) noexcept;

  [[nodiscard]] SourceFlag flag(Source source) const noexcept {
    return trust_[index_of(source)].flag;
  }
  [[nodiscard]] bool trusted(Source source) const noexcept {
    return flag(source) == SourceFlag::ok;
  }

  /// Whether the source is trusted and was consistent with the others at the last check.
  [[nodiscard]] bool agrees(Source source) const noexcept {
    return trusted(source) && !agreed_.contradicted && (suspected_ & only(source)) == 0;
  }

  /// Motion from the short means of all trusted sources at the last check.
  [[nodiscard]] const integrity::Solution& motion() const noexcept {
    return observed_.last_consensus.front();
  }

  /// Other results of the last check.
  struct Agreed {
    integrity::Solution without_gyro;    ///< motion from all trusted sources but the gyro
    integrity::Solution without_wheels;  ///< from all trusted sources but the wheels
    bool wheels_distrusted = false;      ///< all wheels are distrusted
    double reversed_distance = 0.0;  ///< distance driven with the wrong sign until this check [m]
    /// Distance since the last halt while the sign of unsigned wheel speeds is unknown [m].
    double unsigned_distance = 0.0;
    double unsettled_distance = 0.0;  ///< the same, if the car halted at this check [m]
    std::int64_t contradicted_since_ns = 0;
    bool contradicted = false;  ///< sources contradict each other, no fault is isolated
    /// The camera contradicts the filter over several poses, or its clock drifts: the pose is
    /// uncertain while this lasts.
    bool camera_inconsistent = false;
  };
  [[nodiscard]] const Agreed& agreed() const noexcept { return agreed_; }
  /// Whether unsigned wheel speeds are negative, according to all other sources.
  [[nodiscard]] bool backwards() const noexcept { return backwards_; }
  /// Whether the car may slide, at the last check.
  [[nodiscard]] bool slides() const noexcept { return observed_.slides(observed_.now_ns); }
  /// Whether the car slides, so that no model of a turn holds.
  [[nodiscard]] bool slid() const noexcept { return observed_.slid(); }
  /// The recent samples of a source, including those that were not fused.
  [[nodiscard]] const integrity::SourceHistory& history(Source source) const noexcept {
    return observed_.history(source);
  }
  [[nodiscard]] double slip_sigma(Source wheel) const noexcept {
    return observed_.slip_sigma(wheel);
  }
  /// Whether check() has an effect at this time.
  [[nodiscard]] bool is_due(std::int64_t now_ns) const noexcept {
    constexpr std::int64_t interval_ns = 19'000'000;  // 20 ms, less the jitter of the ticks
    return checked_ns() == 0 || ns_between(checked_ns(), now_ns) >= interval_ns;
  }
  /// Time of the last check; 0: never.
  [[nodiscard]] std::int64_t checked_ns() const noexcept { return observed_.now_ns; }

 private:
  struct Trust {
    SourceFlag flag = SourceFlag::ok;
    std::int64_t raised_ns = 0;
    double agreed_s = 0.0;      ///< time since the source last contradicted the others
    double required_s = 0.0;    ///< required agreement before the flag is lowered [s]
    bool by_long_mean = false;  ///< only the long mean has detected the fault
  };

  [[nodiscard]] double surprise(const integrity::CameraStep& step,
                                const CameraPose& pose) const noexcept;
  bool decide_sign(const integrity::Sensors& sensors, integrity::Consensus& all,
                   integrity::Solution& base) noexcept;
  [[nodiscard]] Sources distrusted() const noexcept;
  void raise_flags(Sources suspects, bool by_long_mean) noexcept;
  void lower_flag(Source source, double misfit, double dt) noexcept;

  static constexpr int max_votes = 50;
  static constexpr int decisive_votes = 20;

  integrity::Observations observed_;
  integrity::CameraConsistency camera_innovations_;
  std::array<Trust, source_count> trust_{};
  Sources suspected_ = 0;  ///< at the last check
  std::int64_t suspected_since_ns_ = 0;
  std::array<double, 3> newest_pose_{};
  CameraPose reference_pose_;  ///< start of the camera's step to the next pose
  CameraPose last_outlier_;
  double last_step_speed_ = 0.0;  ///< of the camera's last step, in any direction [m/s]
  int negative_speeds_ = 0;
  int forward_votes_ = decisive_votes / 2;  ///< checks since the last halt, forward minus backwards
  bool halted_ = false;                     ///< the car has stood
  bool backwards_ = false;
  double distance_ = 0.0;  ///< distance since the last halt [m]
  Agreed agreed_;
};

}  // namespace odomd::estimator
