// The unknowns of a drive as the fit has them: windows in a row, a state at each one's begin.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tools/identify/fit/window.hpp"

namespace odomd::tools::fitting {

/// A node at each window's begin and at the end, and what is inside the windows.
struct Chain {
  std::size_t drive = 0;
  std::vector<Window> windows;
  std::vector<Node<double>> nodes;
  std::vector<std::vector<double>> inner;
};

/// The parts of a drive that are fast enough to tell of tyres, two windows at least each. Nodes
/// begin with the poses, the wheels' speed, the gyro, and what slips with them.
[[nodiscard]] std::vector<Chain> chains_of(const Setup& setup, const Drive& drive,
                                           std::size_t index);

/// From the unknowns as they lie in blocks of the fit.
template <class T>
Course<T> course_of(const Setup& setup, const T& begin, const T* inner, const T& end) {
  const auto knots = static_cast<std::ptrdiff_t>(setup.knots());
  Course<T> course;
  course.accel.push_back(begin);
  course.accel.insert(course.accel.end(), inner, inner + knots - 1);
  course.accel.push_back(end);
  course.steering.assign(inner + knots - 1, inner + 2 * knots);
  return course;
}

/// Each sample into the window that its time, by the latencies as they are now, lies in.
void deal(const Numbers<double>& p, const Setup& setup, Chain& chain);

/// Kinds of residuals: those of the sources, and of poses.
inline constexpr std::size_t position_kind = estimator::source_count;
inline constexpr std::size_t yaw_kind = position_kind + 1;

struct ResidualPoint {
  std::size_t drive = 0;
  double t = 0.0;
  std::size_t kind = 0;
  double residual = 0.0;
};

/// What is left of the measurements.
struct Unexplained {
  std::vector<ResidualPoint> points;
  std::array<std::vector<double>, yaw_kind + 1> values;
  std::array<double, yaw_kind + 1> stated{};
};
[[nodiscard]] Unexplained unexplained(const Setup& setup, const std::vector<Chain>& chains,
                                      const Numbers<double>& p);

[[nodiscard]] double robust_sigma(const std::vector<double>& values);

/// Noises from the residuals, where they show more than is stated: model errors count as noise of
/// the source that shows them. (Less they show where a wheel stands for long.)
void take_noises(Setup& setup, const Unexplained& rest);

}  // namespace odomd::tools::fitting
