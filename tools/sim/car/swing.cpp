#include "tools/sim/car/swing.hpp"

#include <cmath>
#include <numbers>

namespace odomd::sim {
namespace {

Eigen::Matrix3d rotation(const Eigen::Vector4d& attitude) {
  return Eigen::Quaterniond(attitude[0], attitude[1], attitude[2], attitude[3])
      .normalized()
      .toRotationMatrix();
}

}  // namespace

SwingRig::SwingRig(const SwingParameters& parameters) : p_(parameters) {
  rest_length_ = p_.cord - p_.stretch;
  stiffness_ = 0.5 * p_.mass * p_.gravity / p_.stretch;
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1.0 : -1.0;
    above_[i] = {0.0, 0.5 * side * p_.spacing_above, 0.0};
    below_[i] = {-p_.offset_across, 0.5 * side * p_.spacing_below - p_.offset_along,
                 p_.height_of_fixings};
  }
  // Settles with strong damping if the centre of gravity is off the cords' midpoint; then deflects.
  state_.attitude = {1.0, 0.0, 0.0, 0.0};
  const double apart = 0.5 * (p_.spacing_above - p_.spacing_below);
  state_.position = {p_.offset_across, p_.offset_along,
                     -std::sqrt(p_.cord * p_.cord - apart * apart) - p_.height_of_fixings};
  const SwingParameters swinging = p_;
  p_.sway_drag = 4.0 * p_.mass;
  p_.viscous = 10.0 * p_.inertia.z();
  const bool plumb = p_.offset_across == 0.0 && p_.offset_along == 0.0;
  for (int i = 0; i < (plumb ? 0 : 10'000); ++i) {
    step(5e-4);
    state_.spin *= 0.999;
  }
  p_ = swinging;
  const double sine = std::sin(0.5 * p_.amplitude);
  const double lift =
      p_.cord - std::sqrt(p_.cord * p_.cord - p_.spacing_above * p_.spacing_below * sine * sine);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(p_.amplitude, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond hung(state_.attitude[0], state_.attitude[1], state_.attitude[2],
                                state_.attitude[3]);
  const Eigen::Quaterniond turned = turn * hung;
  state_.attitude = {turned.w(), turned.x(), turned.y(), turned.z()};
  state_.position.z() += lift;
  state_.velocity.setZero();
  state_.spin.setZero();
  write_output();
  state_.velocity.x() = p_.push;
}

SwingRig::State SwingRig::derivative(const State& state) const {
  const Eigen::Matrix3d body_to_world = rotation(state.attitude);
  Eigen::Vector3d force = {0.0, 0.0, -p_.mass * p_.gravity};
  force -= p_.sway_drag * state.velocity;
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // in body axes
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d arm = body_to_world * below_[i];
    const Eigen::Vector3d cord = above_[i] - (state.position + arm);
    const double length = cord.norm();
    const Eigen::Vector3d along = cord / length;
    const Eigen::Vector3d moving = state.velocity + body_to_world * state.spin.cross(below_[i]);
    // Damped to a few per cent of critical damping.
    const double damping = 0.1 * std::sqrt(stiffness_ * p_.mass);
    const double tension =
        std::fmax(stiffness_ * (length - rest_length_) - damping * moving.dot(along), 0.0);
    force += tension * along;
    torque += below_[i].cross(body_to_world.transpose() * (tension * along));
  }
  const double rate = state.spin.z();
  torque.z() -= p_.viscous * rate + p_.quadratic * std::fabs(rate) * rate;
  // Roll and pitch are damped, too, and die away faster than the swing.
  torque.x() -= p_.viscous * state.spin.x();
  torque.y() -= p_.viscous * state.spin.y();

  State rate_of;
  rate_of.position = state.velocity;
  rate_of.velocity = force / p_.mass;
  const Eigen::Vector3d momentum = p_.inertia.cwiseProduct(state.spin);
  rate_of.spin = (torque - state.spin.cross(momentum)).cwiseQuotient(p_.inertia);
  const Eigen::Vector4d& q = state.attitude;
  const Eigen::Vector3d& w = state.spin;
  rate_of.attitude = 0.5 * Eigen::Vector4d(-q[1] * w.x() - q[2] * w.y() - q[3] * w.z(),
                                           q[0] * w.x() + q[2] * w.z() - q[3] * w.y(),
                                           q[0] * w.y() - q[1] * w.z() + q[3] * w.x(),
                                           q[0] * w.z() + q[1] * w.y() - q[2] * w.x());
  return rate_of;
}

void SwingRig::step(double dt) {
  const auto moved = [](const State& from, const State& rate, double by) {
    State to;
    to.position = from.position + by * rate.position;
    to.velocity = from.velocity + by * rate.velocity;
    to.attitude = from.attitude + by * rate.attitude;
    to.spin = from.spin + by * rate.spin;
    return to;
  };
  const State k1 = derivative(state_);
  const State k2 = derivative(moved(state_, k1, 0.5 * dt));
  const State k3 = derivative(moved(state_, k2, 0.5 * dt));
  const State k4 = derivative(moved(state_, k3, dt));
  state_ = moved(state_, k1, dt / 6.0);
  state_ = moved(state_, k2, dt / 3.0);
  state_ = moved(state_, k3, dt / 3.0);
  state_ = moved(state_, k4, dt / 6.0);
  state_.attitude.normalize();
  write_output();
}

void SwingRig::write_output() {
  const Eigen::Matrix3d body_to_world = rotation(state_.attitude);
  const State rate = derivative(state_);
  const Eigen::Vector3d specific_force =
      body_to_world.transpose() * (rate.velocity + Eigen::Vector3d(0.0, 0.0, p_.gravity));
  const Eigen::Vector3d speed = body_to_world.transpose() * state_.velocity;
  output_.x = state_.position.x();
  output_.y = state_.position.y();
  output_.yaw = std::atan2(body_to_world(1, 0), body_to_world(0, 0));
  output_.v_x = speed.x();
  output_.v_y = speed.y();
  output_.yaw_rate = state_.spin.z();
  output_.yaw_accel = rate.spin.z();
  output_.accel_x = specific_force.x();
  output_.accel_y = specific_force.y();
}

}  // namespace odomd::sim
