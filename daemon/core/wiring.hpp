// Checks that the sensors are wired as the configuration describes them: compares signs, sides,
// axles, axes and units of the sensors over the last tens of seconds of driving.
//
// The filter's own flags report within a fraction of a second that a source is wrong; this check
// finds the cause after seconds, and reports it until the cause is gone.
//
// docs/model.md, "Wiring".
//
// A value type; no heap, no clock, bounded work. Uses only the times of the samples.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "daemon/core/comparison.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::daemon {

/// The fault of a source, in the order of wiring_names.
enum class WiringFault : std::uint8_t {
  none,
  sign,
  left_right_swapped,
  front_rear_swapped,
  axes_swapped,
  unit,
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(WiringFault::count)>
    wiring_names{"ok", "sign", "left_right_swapped", "front_rear_swapped", "axes_swapped", "unit"};

class Wiring {
 public:
  explicit Wiring(const estimator::Vehicle& vehicle) noexcept;

  /// Takes a sample as received, in SI units and in the car's axes. It may be out of range. Samples
  /// may come in any order within a second.
  void add_sample(estimator::Source source, std::int64_t time_ns, double value) noexcept;
  /// Takes a pose of the centre of gravity [m, rad], in any order within a second.
  void add_pose(const estimator::CameraPose& pose) noexcept;

  /// Call once per tick.
  void update(std::int64_t now_ns) noexcept;

  [[nodiscard]] WiringFault fault(std::size_t source) const noexcept { return faults_[source]; }
  /// Whether any source has a fault.
  [[nodiscard]] bool any_fault() const noexcept {
    return std::ranges::any_of(faults_,
                               [](WiringFault fault) { return fault != WiringFault::none; });
  }

  /// The number of compared pairs (wiring_causes.hpp).
  static constexpr std::size_t pair_count = 15 + estimator::wheel_sources.size();
  static constexpr std::uint8_t cause_count = 22 + 2 * estimator::wheel_sources.size();

 private:
  // A weighted sum, and the sum of its weights.
  struct Sum {
    double of = 0.0, weights = 0.0;
    void add(double value, double weight) noexcept {
      of += weight * value;
      weights += weight;
    }
  };
  // The sums over a piece of half a second, with weights that rise or fall in time.
  struct Piece {
    std::array<Sum, estimator::source_count> rising{}, falling{};
    std::array<double, 3> pose{};
    std::uint32_t poses = 0;
  };
  // The means of a piece; NaN without a sample.
  struct Means {
    std::array<double, estimator::source_count> of{}, rising{}, falling{};
    std::array<double, 3> pose{};
    double speed = 0.0;
  };
  // Indices of one or two simultaneous causes (wiring_causes.hpp); cause_count: none.
  using Causes = std::array<std::uint8_t, 2>;
  // Several causes when they cannot be distinguished.
  struct Diagnosis {
    std::array<Causes, 4> causes{Causes{cause_count, cause_count}};
    std::uint8_t count = 1;
    bool operator==(const Diagnosis&) const = default;
  };

  [[nodiscard]] Piece* piece_at(std::int64_t time_ns) noexcept;
  void close(const Piece& piece) noexcept;
  void give_signs(Means& now) noexcept;
  void compare(const Means& before, const Means& now) noexcept;
  void decide() noexcept;

  estimator::Vehicle vehicle_;
  double gentle_;  ///< acceleration below which tyres do not slide [m/s²]
  static constexpr std::size_t open_pieces = 4;
  std::array<Piece, open_pieces> open_{};
  std::int64_t first_open_ = 0;  ///< number of the oldest open piece; 0: none yet
  Means last_{};
  bool speed_has_sign_ = false;
  std::uint32_t ever_ahead_ = 0;  ///< bits of the wheels that have had a positive speed
  std::uint32_t ever_back_ = 0;
  int calm_ = 0;  ///< pieces since the car may last have slid
  int spun_ = 0;  ///< pieces since the wheels of an axle last spun
  std::array<Comparison, pair_count> pairs_{};
  std::uint32_t heard_ = 0;  ///< bits of the sources that have had a sample
  Diagnosis diagnosis_;
  Diagnosis pending_;        ///< the result of the last decisions
  int equal_decisions_ = 0;  ///< number of consecutive equal decisions
  std::array<WiringFault, estimator::source_count> faults_{};
};

}  // namespace odomd::daemon
