// How two signals of a drive go together: slope, offset and correlation of their smoothed courses.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "tools/identify/common/resampled.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// y ≈ slope · x + offset, by least squares.
struct Relation {
  double slope = 0.0;
  double offset = 0.0;
  double correlation = 0.0;
  double spread = 0.0;  ///< median magnitude of the rest
  std::size_t count = 0;

  /// The two have something in common, so that the sign is certain.
  [[nodiscard]] bool clear() const;
};

[[nodiscard]] Relation relation_of(const std::vector<double>& y, const std::vector<double>& x);
/// Over the time that both have.
[[nodiscard]] Relation relation_of(const Series& y, const Series& x);

/// Several signals on one grid over the time that all have, as means over half a second: what is
/// late by less moves together.
class Courses {
 public:
  explicit Courses(const std::vector<const Series*>& signals);

  [[nodiscard]] std::size_t size() const { return courses_.empty() ? 0 : courses_[0].value.size(); }
  [[nodiscard]] const Resampled& of(std::size_t signal) const { return courses_[signal]; }
  [[nodiscard]] double at(std::size_t signal, std::size_t i) const {
    return courses_[signal].value[i];
  }
  /// f(i) for each point of the grid where `use(i)` holds.
  [[nodiscard]] std::vector<double> each(const std::function<double(std::size_t)>& f,
                                         const std::function<bool(std::size_t)>& use) const;

 private:
  std::vector<Resampled> courses_;
};

}  // namespace odomd::tools
