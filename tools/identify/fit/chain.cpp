#include "tools/identify/fit/solver.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/math/median.hpp"

namespace odomd::tools::fitting {
namespace {

namespace st = car_model;

PoseSample pose_near(const FitDrive& drive, double t) {
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

// Commands and their reports have different clocks, and servos move in steps: the uncertainty is
// the signal's change over this number of cycles.
constexpr double uncertain_cycles = 1.0;
double steering_uncertainty(const Setup& setup, const FitDrive& drive, double begin) {
  double sum = 0.0;
  int count = 0;
  for (double t = begin; t < begin + setup.window; t += 0.2 * setup.knot, ++count)
    sum += std::pow(drive.steering.at(t + drive.steering_cycle) - drive.steering.at(t), 2);
  return std::hypot(drive.steering_sigma, uncertain_cycles * std::sqrt(sum / count));
}

Chain chain_between(const Setup& setup, const FitDrive& drive, double begin, std::size_t count) {
  Chain chain;
  const estimator::Vehicle& car = setup.config->vehicle;
  const double sense = car.mass / car.wheelbase();
  const auto accel_at = [&](double t) {
    return (drive.speed.at(t + 0.1) - drive.speed.at(t - 0.1)) / 0.2;
  };
  for (std::size_t k = 0; k <= count; ++k) {
    const double t = begin + static_cast<double>(k) * setup.window;
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
    node[st::states] = accel_at(t);
    chain.nodes.push_back(node);
    if (k == count) break;
    chain.windows.push_back({.drive = &drive,
                             .begin = t,
                             .steering_sigma = steering_uncertainty(setup, drive, t),
                             .samples = {},
                             .poses = {}});
    std::vector<double>& inner = chain.inner.emplace_back(setup.inner(), 0.0);
    for (std::size_t j = 1; j < setup.knots(); ++j)
      inner[j - 1] = accel_at(t + static_cast<double>(j) * setup.knot);
  }
  return chain;
}

bool is_fast(const Setup& setup, const FitDrive& drive, double begin) {
  for (std::size_t k = 0; k <= setup.knots(); ++k)
    if (std::fabs(drive.speed.at(begin + static_cast<double>(k) * setup.knot)) < setup.slow)
      return false;
  return true;
}

}  // namespace

std::vector<Chain> chains_of(const Setup& setup, const FitDrive& drive) {
  std::vector<Chain> chains;
  const auto count = static_cast<std::size_t>((drive.end - drive.begin) / setup.window);
  const auto begin_of = [&](std::size_t k) {
    return drive.begin + static_cast<double>(k) * setup.window;
  };
  std::size_t first = 0;
  for (std::size_t k = 0; k <= count; ++k) {
    if (k < count && is_fast(setup, drive, begin_of(k))) continue;
    if (k - first >= 2) chains.push_back(chain_between(setup, drive, begin_of(first), k - first));
    first = k + 1;
  }
  return chains;
}

void assign_samples(const Numbers<double>& p, const Setup& setup, Chain& chain) {
  const FitDrive& drive = *chain.windows.front().drive;
  for (Window& window : chain.windows) {
    window.samples.clear();
    window.poses.clear();
  }
  const auto window_at = [&](double t) -> Window* {
    const double place = (t - chain.windows.front().begin) / setup.window;
    if (!(place >= 0.0) || place >= static_cast<double>(chain.windows.size())) return nullptr;
    return &chain.windows[static_cast<std::size_t>(place)];
  };
  for (const FitSample& sample : drive.samples)
    if (Window* window = window_at(sample.t - latency_of(setup, sample.source, p)))
      window->samples.push_back(sample);
  for (const PoseSample& pose : drive.poses)
    if (Window* window = window_at(pose.t)) window->poses.push_back(pose);
}

Turns turns_of(const std::vector<Chain>& chains) {
  constexpr double hard = 0.5 * car_model::gravity;
  double bends = 0.0, both = 0.0, pushes = 0.0;
  std::vector<double> accels;
  for (const Chain& chain : chains)
    for (const Node<double>& node : chain.nodes) {
      const double v = node[car_model::v_x], yaw_rate = node[car_model::yaw_rate];
      const double curvature = yaw_rate / v, accel = v * yaw_rate;
      bends += curvature * curvature;
      both += curvature * accel;
      pushes += accel * accel;
      accels.push_back(std::fabs(accel));
    }
  if (!(bends > 0.0) || !(pushes > 0.0)) return {.speed_variety = 1.0};  // no turns
  std::ranges::sort(accels);
  const auto beyond = accels.end() - std::ranges::upper_bound(accels, hard);
  return {.speed_variety = std::sqrt(std::max(0.0, 1.0 - both * both / (bends * pushes))),
          .hard = static_cast<double>(beyond) / static_cast<double>(accels.size()),
          .hardest = accels[accels.size() * 19 / 20]};
}

Residuals residuals_of(const Setup& setup, const std::vector<Chain>& chains,
                       const Numbers<double>& p) {
  Residuals result;
  const auto take = [&](std::size_t kind, double e, double stated) {
    result.values[kind].push_back(e);
    result.stated[kind] = std::max(result.stated[kind], stated);
  };
  for (const Chain& chain : chains)
    for (std::size_t w = 0; w < chain.windows.size(); ++w) {
      const Course<double> course{chain.nodes[w][st::states], chain.inner[w].data(),
                                  chain.nodes[w + 1][st::states], setup.knots()};
      for_each_residual(setup, chain.windows[w], p,
                        run(setup, chain.windows[w], p, chain.nodes[w], course), take);
    }
  return result;
}

void update_noise(Setup& setup, const Residuals& residuals) {
  for (std::size_t kind = 0; kind < kinds; ++kind)
    if (!residuals.values[kind].empty())
      setup.noise[kind] = std::max(robust_sigma(residuals.values[kind]), residuals.stated[kind]);
}

}  // namespace odomd::tools::fitting
