// The newest value of each signal, held until a newer one comes: the whole memory of inputs that
// the models without a window have.
//
// Newest is by the samples' own times, so the order of arrival within a tick does not matter.
#pragma once

#include <array>
#include <cstdint>

#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"

namespace odomd::estimator {

class HeldSignals {
 public:
  explicit HeldSignals(const std::array<double, source_count>& sigma) noexcept;

  /// Takes a sample in, or says why not: non_finite, future (ahead of `latest_ns`), gated (beyond
  /// any car's physics), duplicate, too_old (older than the one held). Not for the camera's.
  Verdict take(const Measurement& sample, std::int64_t latest_ns) noexcept;

  [[nodiscard]] bool seen(Source source) const noexcept { return at(source).seen; }
  [[nodiscard]] std::int64_t time_ns(Source source) const noexcept { return at(source).time_ns; }

  /// 0 where none was seen.
  [[nodiscard]] double value(Source source) const noexcept { return at(source).value; }

  /// Of the sample held, at most the largest value that is not gated; where none was seen, of the
  /// source.
  [[nodiscard]] double sigma(Source source) const noexcept { return at(source).sigma; }

 private:
  struct Held {
    bool seen = false;
    std::int64_t time_ns = 0;
    double value = 0.0;
    double sigma = 0.0;
  };

  [[nodiscard]] const Held& at(Source source) const noexcept {
    return held_[static_cast<std::size_t>(source)];
  }

  std::array<Held, source_count> held_{};
  std::array<double, source_count> sigma_{};
};

}  // namespace odomd::estimator
