// A filter without a window for late samples: it holds the newest value of each signal, advances
// the motion by one step per tick, and has a camera anchor, a mode and integrity monitoring. It has
// the interface of estimator/filter.hpp.
//
// A value type that uses no heap and no clock.
#pragma once

#include <cstdint>
#include <optional>

#include "estimator/baselines/motion.hpp"
#include "estimator/baselines/pose_anchor.hpp"
#include "estimator/baselines/signals.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/integrity/integrity.hpp"
#include "estimator/integrity/mode_monitor.hpp"

namespace odomd::estimator {

class BaselineFilter {
 public:
  /// `model`: any except full.
  BaselineFilter(Model model, const FilterSettings& settings) noexcept;

  void set_initial_pose(const Pose2& pose) noexcept;
  bool resume(const Estimate& predecessor, double gap_s) noexcept;
  Verdict add(const Measurement& sample) noexcept;
  Verdict add(const CameraPose& camera) noexcept;
  Estimate step(std::int64_t tick_ns) noexcept;

  [[nodiscard]] SourceFlag flag(Source source) const noexcept { return integrity_.flag(source); }

 private:
  void advance(std::int64_t tick_ns) noexcept;
  [[nodiscard]] Estimate estimate(std::int64_t tick_ns) noexcept;

  Model model_ = Model::kinematic;
  FilterSettings settings_;
  std::int64_t period_ns_;
  HeldSignals held_;
  GyroBias gyro_bias_;  ///< for the inertial model only
  Motion motion_;
  PoseAnchor anchor_;
  ModeMonitor modes_;
  Integrity integrity_;  ///< does not affect the pose

  std::optional<AxleSpeed> speed_;  ///< the predecessor's speed until the first wheel sample
  std::optional<std::int64_t> last_tick_ns_;
  std::uint32_t recoveries_ = 0;
  Estimate last_;
};

}  // namespace odomd::estimator
