#include "tools/identify/fit/cost.hpp"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/identify/fit/chain.hpp"

namespace odomd::tools::fitting {
namespace {

namespace st = single_track;

constexpr double huber = 2.5;  // in standard deviations

/// Residual e so that e² is Huber's loss.
template <class T>
T bounded(const T& e) {
  using std::sqrt;
  if (number(e) > huber) return sqrt(2.0 * huber * e - huber * huber);
  if (number(e) < -huber) return -sqrt(-2.0 * huber * e - huber * huber);
  return e;
}

// Parameters and states of one window, either as plain numbers or as jets over the free ones.
template <class T>
struct Unknowns {
  Numbers<T> p;
  Node<T> node;
  Course<T> course;
};

template <class T>
void residuals_of(const Setup& setup, const Window& window, const Unknowns<T>& unknowns,
                  std::vector<T>& out, Run<T>& trajectory) {
  trajectory = run(setup, window, unknowns.p, unknowns.node, unknowns.course);
  const four_wheels::Car<T> car = car_of(setup, unknowns.p);
  out.clear();
  for (const Sample& sample : window.samples) {
    const T t = sample.t - latency_of(setup, sample.source, unknowns.p);
    const Instant<T> now = instant(setup, window, trajectory, t);
    const double noise = setup.noise[static_cast<std::size_t>(sample.source)];
    const T h = expected(setup, car, sample, now, unknowns.p);
    out.push_back(
        bounded(static_cast<T>((sample.value - h) / (noise > 0.0 ? noise : sample.sigma))));
  }
  for (const PoseSample& pose : window.poses) {
    const Instant<T> now = instant(setup, window, trajectory, static_cast<T>(pose.t));
    const std::array<T, 3> h = expected_pose(setup, now, unknowns.p);
    const double position = setup.noise_position, yaw = setup.noise_yaw;
    out.push_back(
        bounded(static_cast<T>((pose.x - h[0]) / (position > 0.0 ? position : pose.sigma_x))));
    out.push_back(
        bounded(static_cast<T>((pose.y - h[1]) / (position > 0.0 ? position : pose.sigma_y))));
    out.push_back(bounded(static_cast<T>((pose.yaw - h[2]) / (yaw > 0.0 ? yaw : pose.sigma_yaw))));
  }
  const std::vector<T>& accel = unknowns.course.accel;
  for (std::size_t k = 0; k + 1 < accel.size(); ++k)
    out.push_back((accel[k + 1] - accel[k]) / knot_change);
  for (const T& off : unknowns.course.steering) out.push_back(off);
}

// Blocks: the parameters, this node, what is inside, the next node.
class WindowCost final : public ceres::CostFunction {
 public:
  WindowCost(const Setup& setup, const Window& window, const std::array<bool, parameters>& free)
      : setup_(setup), window_(window) {
    for (std::size_t k = 0; k < parameters; ++k)
      if (free[k]) free_.push_back(k);
    rows_ = window.samples.size() + 3 * window.poses.size() + 2 * setup.knots() + 1 + st::states;
    set_num_residuals(static_cast<int>(rows_));
    auto* blocks = mutable_parameter_block_sizes();
    *blocks = {static_cast<int>(parameters), static_cast<int>(node_size),
               static_cast<int>(setup.inner()), static_cast<int>(node_size)};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    if (jacobians == nullptr) return plain(blocks, residuals);
    const std::size_t local = free_.size() + node_size + setup_.inner() + 1;
    if (local <= 48) return with_jets<48>(blocks, residuals, jacobians);
    if (local <= 68) return with_jets<68>(blocks, residuals, jacobians);
    if (local > 80) return false;
    return with_jets<80>(blocks, residuals, jacobians);
  }

 private:
  bool plain(double const* const* blocks, double* residuals) const {
    Unknowns<double> u;
    std::copy_n(blocks[0], parameters, u.p.begin());
    std::copy_n(blocks[1], node_size, u.node.begin());
    u.course = course_of(setup_, u.node[st::states], blocks[2], blocks[3][st::states]);
    std::vector<double> out;
    Run<double> trajectory;
    residuals_of(setup_, window_, u, out, trajectory);
    std::ranges::copy(out, residuals);
    const auto sigma = believed(setup_);
    for (std::size_t k = 0; k < st::states; ++k)
      residuals[out.size() + k] = (trajectory.states.back()[k] - blocks[3][k]) / sigma[k];
    return std::all_of(residuals, residuals + rows_, [](double e) { return std::isfinite(e); });
  }

  template <int N>
  bool with_jets(double const* const* blocks, double* residuals, double** jacobians) const {
    using Jet = ceres::Jet<double, N>;
    Unknowns<Jet> u;
    int slot = 0;
    for (std::size_t k = 0; k < parameters; ++k) u.p[k] = Jet(blocks[0][k]);
    for (const std::size_t k : free_) u.p[k] = Jet(blocks[0][k], slot++);
    const int node_slot = slot;
    for (std::size_t k = 0; k < node_size; ++k) u.node[k] = Jet(blocks[1][k], slot++);
    const int knot_slot = slot;
    std::vector<Jet> inside;
    for (std::size_t k = 0; k < setup_.inner(); ++k) inside.push_back(Jet(blocks[2][k], slot++));
    const int next_slot = slot;
    u.course =
        course_of(setup_, u.node[st::states], inside.data(), Jet(blocks[3][st::states], slot++));

    std::vector<Jet> out;
    Run<Jet> trajectory;
    residuals_of(setup_, window_, u, out, trajectory);
    const auto sigma = believed(setup_);
    for (std::size_t k = 0; k < st::states; ++k)
      out.push_back((trajectory.states.back()[k] - blocks[3][k]) / sigma[k]);

    const std::size_t inner = setup_.inner();
    for (std::size_t i = 0; i < rows_; ++i) {
      residuals[i] = out[i].a;
      if (!std::isfinite(out[i].a) || !out[i].v.allFinite()) return false;
      if (jacobians[0] != nullptr) {
        double* row = jacobians[0] + i * parameters;
        std::fill_n(row, parameters, 0.0);
        for (std::size_t k = 0; k < free_.size(); ++k)
          row[free_[k]] = out[i].v[static_cast<int>(k)];
      }
      if (jacobians[1] != nullptr)
        for (std::size_t k = 0; k < node_size; ++k)
          jacobians[1][i * node_size + k] = out[i].v[node_slot + static_cast<int>(k)];
      if (jacobians[2] != nullptr)
        for (std::size_t k = 0; k < inner; ++k)
          jacobians[2][i * inner + k] = out[i].v[knot_slot + static_cast<int>(k)];
      if (jacobians[3] != nullptr) {
        double* row = jacobians[3] + i * node_size;
        std::fill_n(row, node_size, 0.0);
        row[st::states] = out[i].v[next_slot];
        const std::size_t first = rows_ - st::states;
        if (i >= first) row[i - first] = -1.0 / sigma[i - first];
      }
    }
    return true;
  }

  const Setup& setup_;
  const Window& window_;
  std::vector<std::size_t> free_;
  std::size_t rows_ = 0;
};

class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const Settings& settings) : free_(settings.free) {
    for (std::size_t k = 0; k < parameters; ++k) known_[k] = settings.known(k);
    set_num_residuals(static_cast<int>(parameters));
    *mutable_parameter_block_sizes() = {static_cast<int>(parameters)};
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    for (std::size_t k = 0; k < parameters; ++k)
      residuals[k] = free_[k] ? (blocks[0][k] - known_[k].value) / known_[k].sigma : 0.0;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::fill_n(jacobians[0], parameters * parameters, 0.0);
      for (std::size_t k = 0; k < parameters; ++k)
        if (free_[k]) jacobians[0][k * parameters + k] = 1.0 / known_[k].sigma;
    }
    return true;
  }

 private:
  Numbers<Measured> known_;
  std::array<bool, parameters> free_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> window_cost(const Setup& setup, const Window& window,
                                                 const std::array<bool, parameters>& free) {
  return std::make_unique<WindowCost>(setup, window, free);
}

std::unique_ptr<ceres::CostFunction> prior_cost(const Settings& settings) {
  return std::make_unique<PriorCost>(settings);
}

}  // namespace odomd::tools::fitting
