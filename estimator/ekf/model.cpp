#include "estimator/ekf/model.hpp"

#include <array>

namespace odomd::estimator::full {
namespace {

double squared(double value) noexcept {
  return value * value;
}

/// What the random walks add.
void add_walks(const Noise& noise, double dt, Matrix& P) noexcept {
  P(at::gyro_bias, at::gyro_bias) += squared(noise.gyro_bias) * dt;
  P(at::gyro_scale, at::gyro_scale) += squared(noise.gyro_scale) * dt;
  P(at::accel_bias_x, at::accel_bias_x) += squared(noise.accel_bias) * dt;
  P(at::accel_bias_y, at::accel_bias_y) += squared(noise.accel_bias) * dt;
  P(at::wheel_scale, at::wheel_scale) += squared(noise.wheel_scale) * dt;
  P(at::steering_offset, at::steering_offset) += squared(noise.steering_offset) * dt;
  P(at::stiffness_scale, at::stiffness_scale) += squared(noise.stiffness_scale) * dt;
}

/// The first eight columns of A Fᵀ, each a sum of those columns of A that F couples. A plain loop
/// over the rows: as quick as expressions of whole columns, and without optimisation far quicker.
template <int Rows>
Eigen::Matrix<double, Rows, 8> changed_columns(const Eigen::Matrix<double, Rows, at::size>& A,
                                               const Step& F) noexcept {
  const auto& by = F.velocity_by;
  // v' by (v_x, v_y, ψ̇, e, e_M, b_ax, δ_0, κ), without what is 0
  const std::array<double, 4> of_v_x{by(0, 0), by(0, 1), by(0, 2), by(0, 5)};
  const std::array<double, 6> of_v_y{by(1, 0), by(1, 1), by(1, 2), by(1, 3), by(1, 6), by(1, 7)};
  const std::array<double, 7> of_turn{by(2, 0), by(2, 1), by(2, 2), by(2, 3),
                                      by(2, 4), by(2, 6), by(2, 7)};
  const double c = F.c;
  const double s = F.s;
  const double dx = F.dx;
  const double dy = F.dy;
  const double decay = F.decay;
  const double moment_decay = F.moment_decay;
  const double half = 0.5 * F.dt;
  Eigen::Matrix<double, Rows, 8> AF;
  const double* const from = A.data();
  double* const to = AF.data();
  for (int i = 0; i < Rows; ++i) {
    const double* const a = from + i;
    double* const b = to + i;
    const double yaw = a[at::yaw * Rows];
    const double v_x = a[at::v_x * Rows];
    const double v_y = a[at::v_y * Rows];
    const double turn = a[at::yaw_rate * Rows];
    const double force = a[at::front_force * Rows];
    const double moment = a[at::yaw_moment * Rows];
    const double offset = a[at::steering_offset * Rows];
    const double stiffness = a[at::stiffness_scale * Rows];
    const double v_x_next = of_v_x[0] * v_x + of_v_x[1] * v_y + of_v_x[2] * turn +
                            of_v_x[3] * a[at::accel_bias_x * Rows];
    const double v_y_next = of_v_y[0] * v_x + of_v_y[1] * v_y + of_v_y[2] * turn +
                            of_v_y[3] * force + of_v_y[4] * offset + of_v_y[5] * stiffness;
    const double turn_next = of_turn[0] * v_x + of_turn[1] * v_y + of_turn[2] * turn +
                             of_turn[3] * force + of_turn[4] * moment + of_turn[5] * offset +
                             of_turn[6] * stiffness;
    // The pose by the mean velocity, ½ (v + v'), and by the yaw: ∂X'/∂ψ_m = -ΔY, ∂Y'/∂ψ_m = ΔX
    const double along = half * (v_x + v_x_next);
    const double across = half * (v_y + v_y_next);
    const double turned = half * (turn + turn_next);
    const double middle = yaw + 0.5 * turned;
    b[at::x * Rows] = a[at::x * Rows] + c * along - s * across - dy * middle;
    b[at::y * Rows] = a[at::y * Rows] + s * along + c * across + dx * middle;
    b[at::yaw * Rows] = yaw + turned;
    b[at::v_x * Rows] = v_x_next;
    b[at::v_y * Rows] = v_y_next;
    b[at::yaw_rate * Rows] = turn_next;
    b[at::front_force * Rows] = decay * force;
    b[at::yaw_moment * Rows] = moment_decay * moment;
  }
  return AF;
}

}  // namespace

VelocityStep velocity_linearised(const CarModel& model, const Input& input, const Vector& state,
                                 double dt) noexcept {
  const Vehicle& car = model.car;
  const double m = car.mass;
  const double j_z = car.yaw_inertia;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const double v_x = state[at::v_x];
  const double v_y = state[at::v_y];
  const double r = state[at::yaw_rate];
  const double e = state[at::front_force];
  const double e_m = state[at::yaw_moment];
  const double k = 1.0 + state[at::stiffness_scale];
  const double w = std::abs(v_x);
  // dw/dv_x; at v_x = 0, where |v_x| has a kink, the mean of both sides.
  const double sign = (v_x > 0.0 ? 1.0 : 0.0) - (v_x < 0.0 ? 1.0 : 0.0);
  const double steered = input.has_steering ? 1.0 : 0.0;
  const double felt = input.has_accel_x ? 1.0 : 0.0;
  const double delta = steered * (input.steering - state[at::steering_offset]);
  const double a_x =
      felt * (input.accel_x - state[at::accel_bias_x] + r * r * model.imu_position[0]);

  // Everything that stiffness multiplies, per unit of k
  const double coupling =
      dt * (l_v * car.cornering_stiffness_front - l_h * car.cornering_stiffness_rear);
  const double steer_by_delta = dt * car.cornering_stiffness_front * v_x;
  const double steer_by_v_x = dt * car.cornering_stiffness_front * delta;
  const double damping_y = dt * (car.cornering_stiffness_front + car.cornering_stiffness_rear);
  const double damping_yaw =
      dt * (l_v * l_v * car.cornering_stiffness_front + l_h * l_h * car.cornering_stiffness_rear);
  const double steer = steer_by_delta * delta;

  // v_y,k = N_y / D_y and ψ̇_k = N_ψ / D_ψ                                  (eqs 32 and 33)
  const double per_y = 1.0 / (m * w + k * damping_y);
  const double per_yaw = 1.0 / (j_z * w + k * damping_yaw);
  const double v_y_next =
      (m * w * v_y + k * (steer - coupling * r) - dt * m * v_x * w * r + dt * m * w * e) * per_y;
  const double r_next =
      (j_z * w * r + k * (l_v * steer - coupling * v_y) + dt * w * (l_v * m * e + j_z * e_m)) *
      per_yaw;

  VelocityStep step;
  step.velocity << v_x + dt * (a_x + v_y * r), v_y_next, r_next;
  // ∂(N/D) = (∂N - (N/D) ∂D) / D; columns v_x, v_y, ψ̇, e, e_M, b_ax, δ_0, κ
  step.by << 1.0, dt * r, dt * (v_y + felt * 2.0 * r * model.imu_position[0]), 0.0, 0.0, -felt * dt,
      0.0, 0.0,  //
      (m * sign * (v_y - v_y_next) + k * steer_by_v_x - dt * m * r * (w + v_x * sign) +
       dt * m * sign * e) *
          per_y,
      m * w * per_y, -(k * coupling + dt * m * v_x * w) * per_y, dt * m * w * per_y, 0.0, 0.0,
      -steered * k * steer_by_delta * per_y,
      (steer - coupling * r - v_y_next * damping_y) * per_y,  //
      (j_z * sign * (r - r_next) + k * l_v * steer_by_v_x + dt * sign * (l_v * m * e + j_z * e_m)) *
          per_yaw,
      -k * coupling * per_yaw, j_z * w * per_yaw, l_v * dt * m * w * per_yaw,
      dt * j_z * w * per_yaw, 0.0, -steered * k * l_v * steer_by_delta * per_yaw,
      (l_v * steer - coupling * v_y - r_next * damping_yaw) * per_yaw;
  return step;
}

Step step_linearised(const CarModel& model, const Input& input, const Vector& state,
                     double dt) noexcept {
  const VelocityStep velocity = velocity_linearised(model, input, state, dt);
  const Eigen::Vector3d before = state.segment<3>(at::v_x);
  const Eigen::Vector3d pose = state.segment<3>(at::x);
  const Eigen::Vector3d after = next_pose<double>(pose, before, velocity.velocity, dt);

  Step step;
  step.mean = state;
  step.mean.segment<3>(at::x) = after;
  step.mean.segment<3>(at::v_x) = velocity.velocity;
  step.decay = model.noise.front_force_s / (model.noise.front_force_s + dt);
  step.mean[at::front_force] *= step.decay;
  step.moment_decay = model.noise.yaw_moment_s / (model.noise.yaw_moment_s + dt);
  step.mean[at::yaw_moment] *= step.moment_decay;

  const double middle = 0.5 * (pose[2] + after[2]);
  step.velocity_by = velocity.by;
  step.dt = dt;
  step.dx = after[0] - pose[0];
  step.dy = after[1] - pose[1];
  step.c = std::cos(middle);
  step.s = std::sin(middle);
  return step;
}

Eigen::Matrix<double, at::size, 8> times_transposed(const Matrix& P, const Step& F) noexcept {
  return changed_columns(P, F);
}

void propagate(const CarModel& model, const Input& input, double dt, Vector& mean,
               Matrix& P) noexcept {
  const Step step = step_linearised(model, input, mean, dt);
  mean = step.mean;

  // P ← F P Fᵀ + Q, with F = identity but for its first eight rows: P Fᵀ, then (P Fᵀ)ᵀ Fᵀ
  const Eigen::Matrix<double, at::size, 8> PF = times_transposed(P, step);
  const Eigen::Matrix<double, 8, at::size> FP = PF.transpose();
  const Eigen::Matrix<double, 8, 8> FPF = changed_columns(FP, step);
  P.topLeftCorner<8, 8>() = FPF.selfadjointView<Eigen::Lower>();
  P.bottomLeftCorner<7, 8>() = PF.bottomRows<7>();
  P.topRightCorner<8, 7>() = FP.rightCols<7>();

  const Noise& noise = model.noise;
  P(at::x, at::x) += squared(noise.position) * dt;
  P(at::y, at::y) += squared(noise.position) * dt;
  P(at::yaw, at::yaw) += squared(noise.yaw) * dt;
  const double felt = input.accel_x - mean[at::accel_bias_x];
  P(at::v_x, at::v_x) += (input.has_accel_x ? squared(noise.v_x) + squared(input.accel_x_density) +
                                                  squared(noise.v_x_per_accel * felt)
                                            : squared(noise.v_x_alone)) *
                         dt;
  P(at::v_y, at::v_y) += squared(noise.v_y) * dt;
  P(at::yaw_rate, at::yaw_rate) += squared(noise.yaw_rate) * dt;
  P(at::front_force, at::front_force) +=
      squared(input.has_steering ? noise.front_force : noise.front_force_alone) *
      (1.0 - squared(step.decay));
  P(at::yaw_moment, at::yaw_moment) +=
      squared(noise.yaw_moment) * (1.0 - squared(step.moment_decay));
  add_walks(noise, dt, P);
}

void propagate_standing(const CarModel& model, double dt, Matrix& covariance) noexcept {
  add_walks(model.noise, dt, covariance);
}

}  // namespace odomd::estimator::full
