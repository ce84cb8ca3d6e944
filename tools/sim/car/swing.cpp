#include "tools/sim/car/swing.hpp"

#include <cmath>
#include <numbers>

namespace odomd::sim {
namespace {

Eigen::Quaterniond quaternion(const Eigen::Vector4d& q) {
  return {q[0], q[1], q[2], q[3]};
}

}  // namespace

SwingRig::SwingRig(const SwingParameters& parameters) : p_(parameters) {
  rest_length_ = p_.cord - p_.stretch;
  stiffness_ = 0.5 * p_.mass * p_.gravity / p_.stretch;
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1.0 : -1.0;
    above_[i] = {0.0, 0.5 * side * p_.spacing_above, 0.0};
    below_[i] = {-p_.offset_across, 0.5 * side * p_.spacing_below - p_.offset_along,
                 p_.height_of_attachment};
  }
  // Settles with strong damping if the centre of gravity is off the cords' midpoint; then deflects.
  state_[attitude] = 1.0;
  const double apart = 0.5 * (p_.spacing_above - p_.spacing_below);
  state_.segment<3>(position) << p_.offset_across, p_.offset_along,
      -std::sqrt(p_.cord * p_.cord - apart * apart) - p_.height_of_attachment;
  const SwingParameters swinging = p_;
  p_.sway_drag = 4.0 * p_.mass;
  p_.viscous = 10.0 * p_.inertia.z();
  const bool plumb = p_.offset_across == 0.0 && p_.offset_along == 0.0;
  for (int i = 0; i < (plumb ? 0 : 10'000); ++i) {
    step(5e-4);
    state_.segment<3>(spin) *= 0.999;
  }
  p_ = swinging;
  const double sine = std::sin(0.5 * p_.amplitude);
  const double lift =
      p_.cord - std::sqrt(p_.cord * p_.cord - p_.spacing_above * p_.spacing_below * sine * sine);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(p_.amplitude, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond turned = turn * quaternion(state_.segment<4>(attitude));
  state_.segment<4>(attitude) << turned.w(), turned.x(), turned.y(), turned.z();
  state_[position + 2] += lift;
  state_.segment<3>(velocity).setZero();
  state_.segment<3>(spin).setZero();
  write_output();
  state_[velocity] = p_.push;
}

SwingRig::State SwingRig::derivative(const State& state) const {
  const Eigen::Vector3d v = state.segment<3>(velocity), w = state.segment<3>(spin);
  const Eigen::Vector4d q = state.segment<4>(attitude);
  const Eigen::Matrix3d body_to_world = quaternion(q).normalized().toRotationMatrix();
  Eigen::Vector3d force = {0.0, 0.0, -p_.mass * p_.gravity};
  force -= p_.sway_drag * v;
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // in body axes
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d arm = body_to_world * below_[i];
    const Eigen::Vector3d cord = above_[i] - (state.segment<3>(position) + arm);
    const double length = cord.norm();
    const Eigen::Vector3d along = cord / length;
    const Eigen::Vector3d moving = v + body_to_world * w.cross(below_[i]);
    // Damped to a few per cent of critical damping.
    const double damping = 0.1 * std::sqrt(stiffness_ * p_.mass);
    const double tension =
        std::fmax(stiffness_ * (length - rest_length_) - damping * moving.dot(along), 0.0);
    force += tension * along;
    torque += below_[i].cross(body_to_world.transpose() * (tension * along));
  }
  // Roll and pitch are damped, too, and die away faster than the swing.
  torque -= p_.viscous * w + Eigen::Vector3d(0.0, 0.0, p_.quadratic * std::fabs(w.z()) * w.z());

  const Eigen::Vector3d momentum = p_.inertia.cwiseProduct(w);
  State rate;
  rate << v, force / p_.mass, 0.5 * (-q[1] * w.x() - q[2] * w.y() - q[3] * w.z()),
      0.5 * (q[0] * w.x() + q[2] * w.z() - q[3] * w.y()),
      0.5 * (q[0] * w.y() - q[1] * w.z() + q[3] * w.x()),
      0.5 * (q[0] * w.z() + q[1] * w.y() - q[2] * w.x()),
      (torque - w.cross(momentum)).cwiseQuotient(p_.inertia);
  return rate;
}

void SwingRig::step(double dt) {
  const State k1 = derivative(state_);
  const State k2 = derivative(state_ + 0.5 * dt * k1);
  const State k3 = derivative(state_ + 0.5 * dt * k2);
  const State k4 = derivative(state_ + dt * k3);
  state_ += dt / 6.0 * k1;
  state_ += dt / 3.0 * k2;
  state_ += dt / 3.0 * k3;
  state_ += dt / 6.0 * k4;
  state_.segment<4>(attitude).normalize();
  write_output();
}

void SwingRig::write_output() {
  const Eigen::Matrix3d body_to_world =
      quaternion(state_.segment<4>(attitude)).normalized().toRotationMatrix();
  const State rate = derivative(state_);
  const Eigen::Vector3d specific_force =
      body_to_world.transpose() *
      (rate.segment<3>(velocity) + Eigen::Vector3d(0.0, 0.0, p_.gravity));
  const Eigen::Vector3d speed = body_to_world.transpose() * state_.segment<3>(velocity);
  output_.x = state_[position];
  output_.y = state_[position + 1];
  output_.yaw = std::atan2(body_to_world(1, 0), body_to_world(0, 0));
  output_.v_x = speed.x();
  output_.v_y = speed.y();
  output_.yaw_rate = state_[spin + 2];
  output_.yaw_accel = rate[spin + 2];
  output_.accel_x = specific_force.x();
  output_.accel_y = specific_force.y();
}

}  // namespace odomd::sim
