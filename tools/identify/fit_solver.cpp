#include "tools/identify/fit_solver.hpp"

#include <ceres/ceres.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "tools/identify/fit_window.hpp"
#include "tools/text.hpp"

namespace odomd::tools::fitting {
namespace {

using estimator::Source;
namespace st = single_track;

constexpr double huber = 2.5;  // in standard deviations
constexpr std::size_t position_kind = estimator::source_count;
constexpr std::size_t yaw_kind = position_kind + 1;

/// Residual e so that e² is Huber's loss.
template <class T>
T bounded(const T& e) {
  using std::sqrt;
  if (number(e) > huber) return sqrt(2.0 * huber * e - huber * huber);
  if (number(e) < -huber) return -sqrt(-2.0 * huber * e - huber * huber);
  return e;
}

// Parameters and states of one window, either as plain numbers or as jets over what is free.
template <class T>
struct Unknowns {
  Numbers<T> p;
  Node<T> node;
  std::vector<T> knots;  // of the acceleration: the node's, those in between, the next node's
};

template <class T>
void residuals_of(const Setup& setup, const Window& window, const Unknowns<T>& unknowns,
                  std::vector<T>& out, Run<T>& trajectory) {
  trajectory = run(setup, window, unknowns.p, unknowns.node, unknowns.knots);
  const st::Car<T> car = car_of(setup, unknowns.p);
  out.clear();
  for (const Sample& sample : window.samples) {
    const T t = sample.t - latency_of(sample.source, unknowns.p);
    const Instant<T> now = instant(setup, window, trajectory, t);
    const double noise = setup.noise[static_cast<std::size_t>(sample.source)];
    const T h = expected(setup, car, sample, now, unknowns.p);
    out.push_back(bounded(T((sample.value - h) / (noise > 0.0 ? noise : sample.sigma))));
  }
  for (const PoseSample& pose : window.poses) {
    const Instant<T> now = instant(setup, window, trajectory, T(pose.t));
    const std::array<T, 3> h = expected_pose(setup, now, unknowns.p);
    const double position = setup.noise_position, yaw = setup.noise_yaw;
    out.push_back(bounded(T((pose.x - h[0]) / (position > 0.0 ? position : pose.sigma_x))));
    out.push_back(bounded(T((pose.y - h[1]) / (position > 0.0 ? position : pose.sigma_y))));
    out.push_back(bounded(T((pose.yaw - h[2]) / (yaw > 0.0 ? yaw : pose.sigma_yaw))));
  }
  for (std::size_t k = 0; k + 1 < unknowns.knots.size(); ++k)
    out.push_back((unknowns.knots[k + 1] - unknowns.knots[k]) / knot_change);
}

// Blocks: the parameters, this node, the knots in between, the next node.
class WindowCost final : public ceres::CostFunction {
 public:
  WindowCost(const Setup& setup, const Window& window, const std::array<bool, parameters>& free)
      : setup_(setup), window_(window) {
    for (std::size_t k = 0; k < parameters; ++k)
      if (free[k]) free_.push_back(k);
    rows_ = window.samples.size() + 3 * window.poses.size() + setup.knots() + st::states;
    set_num_residuals(static_cast<int>(rows_));
    auto* blocks = mutable_parameter_block_sizes();
    *blocks = {static_cast<int>(parameters), static_cast<int>(node_size),
               static_cast<int>(setup.knots() - 1), static_cast<int>(node_size)};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    if (jacobians == nullptr) return plain(blocks, residuals);
    const std::size_t local = free_.size() + node_size + setup_.knots();
    if (local <= 40) return with_jets<40>(blocks, residuals, jacobians);
    if (local <= 56) return with_jets<56>(blocks, residuals, jacobians);
    return with_jets<72>(blocks, residuals, jacobians);
  }

 private:
  bool plain(double const* const* blocks, double* residuals) const {
    Unknowns<double> u;
    std::copy_n(blocks[0], parameters, u.p.begin());
    std::copy_n(blocks[1], node_size, u.node.begin());
    u.knots.push_back(u.node[st::states]);
    u.knots.insert(u.knots.end(), blocks[2], blocks[2] + setup_.knots() - 1);
    u.knots.push_back(blocks[3][st::states]);
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
    u.knots.push_back(u.node[st::states]);
    for (std::size_t k = 0; k + 1 < setup_.knots(); ++k)
      u.knots.push_back(Jet(blocks[2][k], slot++));
    const int next_slot = slot;
    u.knots.push_back(Jet(blocks[3][st::states], slot++));

    std::vector<Jet> out;
    Run<Jet> trajectory;
    residuals_of(setup_, window_, u, out, trajectory);
    const auto sigma = believed(setup_);
    for (std::size_t k = 0; k < st::states; ++k)
      out.push_back((trajectory.states.back()[k] - blocks[3][k]) / sigma[k]);

    const std::size_t inner = setup_.knots() - 1;
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
  PriorCost(const Numbers<double>& doubt, const std::array<bool, parameters>& free)
      : doubt_(doubt), free_(free) {
    set_num_residuals(static_cast<int>(parameters));
    *mutable_parameter_block_sizes() = {static_cast<int>(parameters)};
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    for (std::size_t k = 0; k < parameters; ++k)
      residuals[k] = free_[k] ? blocks[0][k] / doubt_[k] : 0.0;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::fill_n(jacobians[0], parameters * parameters, 0.0);
      for (std::size_t k = 0; k < parameters; ++k)
        if (free_[k]) jacobians[0][k * parameters + k] = 1.0 / doubt_[k];
    }
    return true;
  }

 private:
  Numbers<double> doubt_;
  std::array<bool, parameters> free_;
};

/// The unknowns of one drive: a node at each window's begin and at the end, knots in between.
struct Chain {
  std::size_t drive = 0;
  std::vector<Window> windows;
  std::vector<Node<double>> nodes;
  std::vector<std::vector<double>> knots;
};

PoseSample pose_near(const Drive& drive, double t) {
  const auto after = std::ranges::lower_bound(drive.poses, t, {}, &PoseSample::t);
  if (after == drive.poses.begin()) return *after;
  if (after == drive.poses.end()) return drive.poses.back();
  const auto before = std::prev(after);
  const double part = (t - before->t) / (after->t - before->t);
  PoseSample pose = *before;
  pose.x += part * (after->x - before->x);
  pose.y += part * (after->y - before->y);
  pose.yaw += part * (after->yaw - before->yaw);
  return pose;
}

// Where the nodes begin: the pose's, the wheels' speed, the gyro, and what slips with them.
Chain chain_of(const Setup& setup, const Drive& drive, std::size_t index) {
  Chain chain{.drive = index, .windows = {}, .nodes = {}, .knots = {}};
  const auto count = static_cast<std::size_t>((drive.end - drive.begin) / setup.window);
  const estimator::Vehicle& car = setup.config->vehicle;
  const double sense = car.mass / car.wheelbase();
  for (std::size_t k = 0; k <= count; ++k) {
    const double t = drive.begin + static_cast<double>(k) * setup.window;
    const double v = drive.speed.at(t), r = drive.yaw_rate.at(t);
    const PoseSample pose = pose_near(drive, t);
    Node<double> node{};
    node[st::yaw] = pose.yaw - setup.nominal[camera_yaw];
    const double c = std::cos(node[st::yaw]), s = std::sin(node[st::yaw]);
    const double x = setup.nominal[camera_x], y = setup.nominal[camera_y];
    node[st::pos_x] = pose.x - c * x + s * y;
    node[st::pos_y] = pose.y - s * x - c * y;
    node[st::v_x] = v;
    node[st::yaw_rate] = r;
    node[st::slip_front] = sense * car.rear_axle * v * r / car.cornering_stiffness_front;
    node[st::slip_rear] = sense * car.front_axle * v * r / car.cornering_stiffness_rear;
    node[st::v_y] = car.rear_axle * r - std::fabs(v) * node[st::slip_rear];
    node[st::steer] = drive.steering.at(t);
    node[st::states] = (drive.speed.at(t + 0.1) - drive.speed.at(t - 0.1)) / 0.2;
    chain.nodes.push_back(node);
    if (k == count) break;
    chain.windows.push_back({.drive = &drive, .begin = t, .samples = {}, .poses = {}});
    std::vector<double> inner;
    for (std::size_t j = 1; j < setup.knots(); ++j) {
      const double at = t + static_cast<double>(j) * setup.knot;
      inner.push_back((drive.speed.at(at + 0.1) - drive.speed.at(at - 0.1)) / 0.2);
    }
    chain.knots.push_back(std::move(inner));
  }
  return chain;
}

// Each sample into the window that its time, by the latencies as they are now, lies in.
void deal(const Setup& setup, const Numbers<double>& p, Chain& chain) {
  const Drive& drive = *chain.windows.front().drive;
  for (Window& window : chain.windows) {
    window.samples.clear();
    window.poses.clear();
  }
  const auto window_at = [&](double t) -> Window* {
    const double place = (t - drive.begin) / setup.window;
    if (!(place >= 0.0) || place >= static_cast<double>(chain.windows.size())) return nullptr;
    return &chain.windows[static_cast<std::size_t>(place)];
  };
  for (const Sample& sample : drive.samples)
    if (Window* window = window_at(sample.t - latency_of(sample.source, p)))
      window->samples.push_back(sample);
  for (const PoseSample& pose : drive.poses)
    if (Window* window = window_at(pose.t)) window->poses.push_back(pose);
}

std::string name_of_kind(std::size_t kind) {
  if (kind == position_kind) return "position";
  if (kind == yaw_kind) return "yaw";
  return std::string(estimator::source_names[kind]);
}

struct Unexplained {
  std::vector<ResidualPoint> points;
  std::array<std::vector<double>, yaw_kind + 1> values;
  std::array<double, yaw_kind + 1> stated{};
};

Unexplained unexplained(const Setup& setup, const std::vector<Chain>& chains,
                        const Numbers<double>& p) {
  Unexplained result;
  const auto take = [&](std::size_t drive, double t, std::size_t kind, double e, double stated) {
    result.points.push_back({drive, t, kind, e});
    result.values[kind].push_back(e);
    result.stated[kind] = std::max(result.stated[kind], stated);
  };
  for (const Chain& chain : chains) {
    for (std::size_t w = 0; w < chain.windows.size(); ++w) {
      const Window& window = chain.windows[w];
      std::vector<double> knots{chain.nodes[w][st::states]};
      knots.insert(knots.end(), chain.knots[w].begin(), chain.knots[w].end());
      knots.push_back(chain.nodes[w + 1][st::states]);
      const Run<double> trajectory = run(setup, window, p, chain.nodes[w], knots);
      const st::Car<double> car = car_of(setup, p);
      for (const Sample& sample : window.samples) {
        const auto now =
            instant(setup, window, trajectory, sample.t - latency_of(sample.source, p));
        take(chain.drive, sample.t, static_cast<std::size_t>(sample.source),
             sample.value - expected(setup, car, sample, now, p), sample.sigma);
      }
      for (const PoseSample& pose : window.poses) {
        const auto now = instant(setup, window, trajectory, pose.t);
        const auto h = expected_pose(setup, now, p);
        take(chain.drive, pose.t, position_kind, pose.x - h[0], pose.sigma_x);
        take(chain.drive, pose.t, position_kind, pose.y - h[1], pose.sigma_y);
        take(chain.drive, pose.t, yaw_kind, pose.yaw - h[2], pose.sigma_yaw);
      }
    }
  }
  return result;
}

double robust_sigma(std::vector<double> values) {
  if (values.empty()) return 0.0;
  for (double& value : values) value = std::fabs(value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return 1.4826 * *middle;
}

// Noises from the residuals, where they show more than is stated: model errors count as noise of
// the source that shows them. (Less they show where a wheel stands for long.)
void take_noises(Setup& setup, const Unexplained& rest) {
  const auto noise = [&](std::size_t kind) {
    const double found = robust_sigma(rest.values[kind]);
    return std::max(found, rest.stated[kind]);
  };
  for (std::size_t kind = 0; kind < estimator::source_count; ++kind)
    if (!rest.values[kind].empty()) setup.noise[kind] = noise(kind);
  setup.noise_position = noise(position_kind);
  setup.noise_yaw = noise(yaw_kind);
}

class Teller final : public ceres::IterationCallback {
 public:
  Teller(const Settings& settings, int pass) : settings_(settings), pass_(pass) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (settings_.progress)
      settings_.progress("pass " + std::to_string(pass_) + " of " +
                         std::to_string(settings_.passes) + ", iteration " +
                         std::to_string(summary.iteration) + ": cost " + fixed(summary.cost, 1));
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const Settings& settings_;
  int pass_;
};

struct Built {
  std::unique_ptr<ceres::Problem> problem;
  std::vector<ceres::ResidualBlockId> blocks;  // windows in order, then the prior
  std::vector<std::size_t> cluster;            // of each block
  std::vector<double*> unknowns;               // the parameters first
};

Built build(const Setup& setup, const Settings& settings, Numbers<double>& p,
            std::vector<Chain>& chains) {
  Built built;
  built.problem = std::make_unique<ceres::Problem>();
  built.unknowns.push_back(p.data());
  std::size_t cluster = 0;
  const auto per_cluster = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(settings.cluster / setup.window)));
  for (Chain& chain : chains) {
    for (std::size_t w = 0; w < chain.windows.size(); ++w) {
      if (w % per_cluster == 0) ++cluster;
      built.blocks.push_back(built.problem->AddResidualBlock(
          new WindowCost(setup, chain.windows[w], settings.free), nullptr, p.data(),
          chain.nodes[w].data(), chain.knots[w].data(), chain.nodes[w + 1].data()));
      built.cluster.push_back(cluster);
      built.unknowns.push_back(chain.nodes[w].data());
      built.unknowns.push_back(chain.knots[w].data());
    }
    built.unknowns.push_back(chain.nodes.back().data());
  }
  built.blocks.push_back(built.problem->AddResidualBlock(
      new PriorCost(settings.doubt, settings.free), nullptr, p.data()));
  built.cluster.push_back(cluster + 1);
  std::vector<int> constant;
  for (std::size_t k = 0; k < parameters; ++k)
    if (!settings.free[k]) constant.push_back(static_cast<int>(k));
  if (!constant.empty())
    built.problem->SetManifold(p.data(),
                               new ceres::SubsetManifold(static_cast<int>(parameters), constant));
  return built;
}

// With the Jacobian J at the solution, A = Jᵀ J, and the rows of one cluster together:
//   cov = A⁻¹ (Σ_c s_c s_cᵀ + P) A⁻¹,  s_c = J_cᵀ e_c,  P the priors' part of A,
// of which only the parameters' rows are needed: A⁻¹ E.
void uncertainties(const Built& built, const Settings& settings, Result& result) {
  std::vector<std::size_t> free;
  for (std::size_t k = 0; k < parameters; ++k)
    if (settings.free[k]) free.push_back(k);
  const auto count = static_cast<Eigen::Index>(free.size());

  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = built.unknowns;
  options.residual_blocks = built.blocks;
  options.num_threads = settings.threads;
  ceres::CRSMatrix crs;
  std::vector<double> e;
  double cost = 0.0;
  if (!built.problem->Evaluate(options, &cost, &e, nullptr, &crs))
    throw std::runtime_error("the fit's uncertainty could not be computed");
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(
      crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
      crs.cols.data(), crs.values.data());
  Eigen::SparseMatrix<double> a =
      (Eigen::SparseMatrix<double>(jacobian.transpose()) * Eigen::SparseMatrix<double>(jacobian));
  for (Eigen::Index k = 0; k < a.rows(); ++k) a.coeffRef(k, k) += 1e-9;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(a);
  if (factor.info() != Eigen::Success)
    throw std::runtime_error("the fit's information is singular: fix some parameters (--fix)");
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(a.rows(), count);
  unit.topRows(count) = Eigen::MatrixXd::Identity(count, count);
  const Eigen::MatrixXd inverse = factor.solve(unit);  // columns of A⁻¹

  const Eigen::MatrixXd naive = inverse.topRows(count);
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double doubt = settings.doubt[free[static_cast<std::size_t>(k)]];
    prior(k, k) = 1.0 / (doubt * doubt);
  }
  Eigen::MatrixXd sandwich = naive * prior * naive;
  Eigen::VectorXd influence = Eigen::VectorXd::Zero(count);
  Eigen::Index row = 0;
  std::size_t cluster = built.cluster.front(), clusters = 0;
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t b = 0; b + 1 < built.blocks.size(); ++b) {
    if (built.cluster[b] != cluster) {
      scatter += influence * influence.transpose();
      influence.setZero();
      cluster = built.cluster[b];
      ++clusters;
    }
    const int rows =
        built.problem->GetCostFunctionForResidualBlock(built.blocks[b])->num_residuals();
    for (int i = 0; i < rows; ++i, ++row)
      for (Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>::InnerIterator it(
               jacobian, row);
           it; ++it)
        influence +=
            inverse.row(it.col()).transpose() * (it.value() * e[static_cast<std::size_t>(row)]);
  }
  scatter += influence * influence.transpose();
  ++clusters;
  sandwich += scatter *
              (static_cast<double>(clusters) / std::max(1.0, static_cast<double>(clusters) - 1.0));

  result.covariance = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parameters),
                                            static_cast<Eigen::Index>(parameters));
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t k = free[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < count; ++j)
      result.covariance(static_cast<Eigen::Index>(k),
                        static_cast<Eigen::Index>(free[static_cast<std::size_t>(j)])) =
          i == j ? std::max(sandwich(i, i), naive(i, i)) : sandwich(i, j);
    result.naive[k] = std::sqrt(std::max(naive(i, i), 0.0));
    result.sigma[k] = std::sqrt(std::max(sandwich(i, i), naive(i, i)));
  }
  result.cost = cost;
}

double rounded_window(double wanted, double knot) {
  return knot * std::max(2.0, std::round(wanted / knot));
}

}  // namespace

Result solve(const daemon::Config& config, std::span<const Drive> drives,
             const Settings& settings) {
  const estimator::Vehicle& car = config.vehicle;
  Setup setup;
  setup.config = &config;
  setup.nominal = nominal_values(config);
  setup.wheelbase = car.wheelbase();
  setup.window = rounded_window(settings.window, setup.knot);
  setup.floor_speed =
      std::max(0.02, single_track::floor_speed(car.mass, car.front_axle, car.rear_axle,
                                               car.yaw_inertia, car.cornering_stiffness_front,
                                               car.cornering_stiffness_rear, setup.step) /
                         3.0);
  std::vector<Chain> chains;
  for (std::size_t k = 0; k < drives.size(); ++k) chains.push_back(chain_of(setup, drives[k], k));

  Result result;
  result.p = settings.start;
  for (int pass = 1; pass <= settings.passes; ++pass) {
    for (Chain& chain : chains) deal(setup, result.p, chain);
    Built built = build(setup, settings, result.p, chains);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.max_num_iterations = settings.iterations;
    options.function_tolerance = pass == settings.passes ? 1e-7 : 1e-4;
    options.num_threads = settings.threads;
    options.logging_type = ceres::SILENT;
    options.initial_trust_region_radius = 1e4;
    Teller teller(settings, pass);
    options.callbacks.push_back(&teller);
    // Windows' insides go first, then the nodes along the chain, the parameters last of all.
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    ordering->AddElementToGroup(result.p.data(), 2);
    for (Chain& chain : chains) {
      for (Node<double>& node : chain.nodes) ordering->AddElementToGroup(node.data(), 1);
      for (std::vector<double>& inner : chain.knots) ordering->AddElementToGroup(inner.data(), 0);
    }
    options.linear_solver_ordering = std::move(ordering);
    ceres::Solver::Summary summary;
    ceres::Solve(options, built.problem.get(), &summary);
    result.iterations += static_cast<int>(summary.iterations.size());
    if (!summary.IsSolutionUsable())
      throw std::runtime_error("the fit does not converge: " + summary.message);
    if (pass < settings.passes) {
      take_noises(setup, unexplained(setup, chains, result.p));
    } else {
      uncertainties(built, settings, result);
    }
  }

  Unexplained rest = unexplained(setup, chains, result.p);
  for (std::size_t kind = 0; kind <= yaw_kind; ++kind)
    result.sources.push_back({name_of_kind(kind), rest.values[kind].size(), rest.stated[kind],
                              robust_sigma(rest.values[kind])});
  result.residuals = std::move(rest.points);
  return result;
}

}  // namespace odomd::tools::fitting
