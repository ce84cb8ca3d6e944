// The unknowns of a drive in the fit: successive windows with a state at the start of each.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tools/identify/fit/window.hpp"

namespace odomd::tools::fitting {

/// A node at the start of each window and at the end, and the unknowns inside the windows.
struct Chain {
  std::size_t drive = 0;
  std::vector<Window> windows;
  std::vector<Node<double>> nodes;
  std::vector<std::vector<double>> inner;
};

/// The parts of a drive that are fast enough to show the tyres, at least two windows each. Nodes
/// are initialised from the poses, the wheels' speed, the gyro, and the corresponding slip.
[[nodiscard]] std::vector<Chain> chains_of(const Setup& setup, const Drive& drive,
                                           std::size_t index);

/// Assigns each sample to the window of its time, by the present latencies.
void deal(const Numbers<double>& p, const Setup& setup, Chain& chain);

/// Statistics of the drive's turns, from the states at the windows' ends.
struct Turns {
  /// How little the lateral acceleration is correlated with the curvature: 0 at one speed, 0.46 on
  /// the exercise in the help.
  //
  // With κ = ψ̇ / v, a = v ψ̇ and a_0 = κ Σ a κ / Σ κ²: sqrt(Σ (a - a_0)² / Σ a²). On a circle the
  // single-track model has δ = l κ + (m l_h / C_v - m l_v / C_h) a / l: without variety, the
  // steering's scale and the tyres are one number.
  double speed_variety = 0.0;
  double hard = 0.0;     ///< share of the time above half of the grip of dry tyres, 0.5 g
  double hardest = 0.0;  ///< lateral acceleration exceeded for a twentieth of the time [m/s²]
};
[[nodiscard]] Turns turns_of(const std::vector<Chain>& chains);

struct ResidualPoint {
  std::size_t drive = 0;
  double t = 0.0;
  std::size_t kind = 0;
  double residual = 0.0;
};

/// The residuals of the measurements.
struct Unexplained {
  std::vector<ResidualPoint> points;
  std::array<std::vector<double>, kinds> values;
  std::array<double, kinds> stated{};
};
[[nodiscard]] Unexplained unexplained(const Setup& setup, const std::vector<Chain>& chains,
                                      const Numbers<double>& p);

/// Noise from the residuals if it is larger than stated: model errors count as noise of the source
/// that shows them. (It is smaller if a wheel stands for long.)
void take_noises(Setup& setup, const Unexplained& rest);

}  // namespace odomd::tools::fitting
