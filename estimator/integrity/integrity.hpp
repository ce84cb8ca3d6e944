// Which sources tell the truth: what they say of one motion must agree, and where it does not, the
// fewest whose absence explains it are at fault.
//
// docs/model.md, "Integrity".
//
// A value; no heap, no clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "estimator/common/measurement.hpp"
#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/parity.hpp"

namespace odomd::estimator {

enum class SourceFlag : std::uint8_t {
  ok,
  out_of_range,  ///< beyond what any car does (admission.hpp), twice in a row
  non_finite,    ///< NaN, infinity or an impossible sigma, twice in a row
  frozen,        ///< the same bits again and again, while the car has moved on
  drifting,      ///< the others, which agree, contradict it
  slipping,      ///< a wheel, an axle or the motor: it turns otherwise than the car moves
  timed_out,     ///< this and the next are for those who know the bus
  failed_protection,
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(SourceFlag::count)>
    source_flag_names{"ok",       "out_of_range", "non_finite", "frozen",
                      "drifting", "slipping",     "timed_out",  "failed_protection"};

class Integrity {
 public:
  /// A sample of the car's own sensors, newer than the last of its source; a wheel's with the sign
  /// of the direction where there is one.
  /// `heard_ns`: when it came in; 0: it is held against the others at its own time.
  void hear(Source source, std::int64_t time_ns, double value, double sigma,
            std::int64_t heard_ns = 0) noexcept;
  void hear(const CameraPose& pose) noexcept;

  /// What has been learnt of the sensors since.
  void know(const integrity::Known& known) noexcept { heard_.known = known; }

  /// Holds the sources against each other, once in 20 ms.
  void look(const integrity::Sensors& sensors, std::int64_t now_ns) noexcept;

  [[nodiscard]] SourceFlag flag(Source source) const noexcept {
    return trust_[index_of(source)].flag;
  }
  [[nodiscard]] bool trusted(Source source) const noexcept {
    return flag(source) == SourceFlag::ok;
  }

  /// Trusted, and in agreement with the others at the last look.
  [[nodiscard]] bool agrees(Source source) const noexcept {
    return trusted(source) && !agreed_.contradicted && (suspected_ & integrity::only(source)) == 0;
  }

  /// What the sources that are trusted agree on, at the last look.
  struct Agreed {
    double speed = 0.0;  ///< v_x [m/s], a short mean
    double speed_sigma = 0.0;
    double turn = 0.0;  ///< ψ̇ [rad/s], likewise
    double turn_sigma = 0.0;
    double turn_without_gyro = 0.0;  ///< by all others [rad/s]
    double turn_without_gyro_sigma = 0.0;
    double speed_without_wheels = 0.0;  ///< by all others [m/s]
    double speed_without_wheels_sigma = 0.0;
    bool wheels_out = false;  ///< all of them are distrusted
    double way_back = 0.0;    ///< [m] driven since the last halt, which was the other way round
    std::int64_t contradicted_since_ns = 0;
    bool contradicted = false;  ///< they do not agree, and no source can be told to be at fault
  };
  [[nodiscard]] const Agreed& agreed() const noexcept { return agreed_; }
  /// Wheels that know no sign turn backwards, by what all others say.
  [[nodiscard]] bool backwards() const noexcept { return backwards_; }
  [[nodiscard]] std::int64_t looked_ns() const noexcept { return looked_ns_; }

 private:
  struct Trust {
    SourceFlag flag = SourceFlag::ok;
    std::int64_t raised_ns = 0;
    double agreed_s = 0.0;  ///< for so long the flag has not been deserved
    double calm_s = 0.0;    ///< that it must agree for before it is trusted again
    bool slowly = false;    ///< it took the long mean to tell
  };

  bool settle_sign(const integrity::Sensors& sensors, integrity::Consensus& all,
                   integrity::Solution& base) noexcept;
  [[nodiscard]] integrity::Sources distrusted() const noexcept;
  void accuse(integrity::Sources suspects, bool slowly) noexcept;
  void trust_again(std::size_t source, double misfit, double dt) noexcept;

  static constexpr int most_looks = 50;     ///< that say which way it goes
  static constexpr int settled_looks = 20;  ///< that settle it

  integrity::Heard heard_;
  std::array<Trust, source_count> trust_{};
  integrity::Sources suspected_ = 0;  ///< by the last look
  std::int64_t suspected_since_ns_ = 0;
  integrity::Sources heard_now_ = 0;  ///< at the last look
  std::array<double, 3> newest_pose_{};
  CameraPose seen_from_;        ///< the pose that the next is told from
  bool strayed_ = false;        ///< the newest was off by more than any motion
  int negative_speeds_ = 0;     ///< that were heard
  int ahead_rather_ = 10;       ///< looks since the last halt that say so, less the others
  bool halted_ = false;         ///< it has been seen at rest
  bool backwards_ = false;      ///< wheels that know no sign turn backwards
  double way_ = 0.0;            ///< since the last halt [m]
  std::int64_t looked_ns_ = 0;  ///< 0: never
  Agreed agreed_;
};

}  // namespace odomd::estimator
