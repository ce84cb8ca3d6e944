// Compares the process model with automatic differentiation and with its parts.
#include "estimator/ekf/process_model.hpp"

#include "derivatives.hpp"
#include "tests/estimator/autodiff.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::process_model_test {
namespace {

using estimator::testing::jacobian;
using estimator::testing::values;
using estimator::testing::variables;

constexpr double dt = 0.005;

/// The states, then κ.
constexpr int variable_count = at::size + 1;
using Dual = estimator::testing::Dual<variable_count>;
using DualVector = Eigen::Matrix<Dual, at::size, 1>;

struct Stiffnesses {
  Dual front;
  Dual rear;
};

/// Independent implementation of eqs 32 and 33 with |v_x| and the stiffnesses of a step, and of eqs
/// 8 and 9 with its mean velocity.
DualVector next(const CarModel& model, const Input& input, const Stiffnesses& tyres,
                const DualVector& x, const Dual& kappa) {
  using std::abs;
  using std::cos;
  using std::sin;
  const Vehicle& car = model.car;
  const Dual c_v = tyres.front * (1.0 + kappa);
  const Dual c_h = tyres.rear * (1.0 + kappa);
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const Dual v_x = x[at::v_x];
  const Dual v_y = x[at::v_y];
  const Dual yaw_rate = x[at::yaw_rate];
  const Dual w = abs(v_x);
  Dual delta = x[at::front_angle];
  if (input.has_steering) delta += input.steering - x[at::steering_offset];
  const Dual a = car.mass * w * v_y - dt * (l_v * c_v - l_h * c_h) * yaw_rate;
  const Dual b = -dt * c_v * delta * v_x + dt * car.mass * v_x * w * yaw_rate -
                 dt * car.mass * w * x[at::side_force];
  const Dual c = car.yaw_inertia * w * yaw_rate - dt * (l_v * c_v - l_h * c_h) * v_y;
  const Dual d = -dt * l_v * c_v * delta * v_x;

  DualVector after = x;
  after[at::v_x] = v_x + dt * (x[at::accel_x] + v_y * yaw_rate);
  after[at::v_y] = (a - b) / (car.mass * w + dt * (c_v + c_h));
  after[at::yaw_rate] = (c - d) / (car.yaw_inertia * w + dt * (l_v * l_v * c_v + l_h * l_h * c_h));
  const Dual along = 0.5 * (v_x + after[at::v_x]);
  const Dual across = 0.5 * (v_y + after[at::v_y]);
  const Dual turn = 0.5 * (yaw_rate + after[at::yaw_rate]);
  const Dual yaw = x[at::yaw] + 0.5 * dt * turn;
  after[at::x] = x[at::x] + dt * (along * cos(yaw) - across * sin(yaw));
  after[at::y] = x[at::y] + dt * (along * sin(yaw) + across * cos(yaw));
  after[at::yaw] = x[at::yaw] + dt * turn;
  const Tuning& tuning = model.tuning;
  after[at::accel_x] = x[at::accel_x] * (tuning.driving_s / (tuning.driving_s + dt));
  after[at::front_angle] = x[at::front_angle] * (tuning.driving_s / (tuning.driving_s + dt));
  after[at::side_force] = x[at::side_force] * (tuning.side_force_s / (tuning.side_force_s + dt));
  return after;
}

/// F(α)/α, α = across / rolls, of a brush tyre (Pacejka): F = C α (1 - q + q²/3), and the largest
/// force if the tyre slides.
Dual secant(double stiffness, double across, double most, const Dual& rolls) {
  const Dual q = stiffness * std::abs(across) / (3.0 * most) / rolls;
  return q.value() < 1.0 ? Dual(stiffness * (1.0 - q + q * q / 3.0))
                         : Dual(most / std::abs(across) * rolls);
}

/// F(α)/α of both axles at a state; it depends on |v_x| only if a tyre slides sideways at a low
/// speed.
Stiffnesses tyres_at(const CarModel& model, const Input& input, const State& state,
                     const Dual& v_x) {
  using std::abs;
  const Vehicle& car = model.car;
  const double delta = moving(state, input).front_wheel;
  const double v_y = state.mean[at::v_y];
  const double yaw_rate = state.mean[at::yaw_rate];
  const auto axle = [&](double stiffness, double across, double grip, double share) {
    const double softness =
        (grip > 0.0 ? 1.0 / grip : Tuning{}.tyre_softness) + state.slow.mean[slow::softness];
    const double w = std::abs(v_x.value());
    const double least = car.wheelbase() - std::abs(across);
    const Dual rolls = w > least && w < car.wheelbase() ? Dual(abs(v_x)) : Dual(std::max(w, least));
    return secant(stiffness, across, car.mass * share / softness, rolls);
  };
  return {axle(car.cornering_stiffness_front, delta * v_x.value() - v_y - car.front_axle * yaw_rate,
               car.grip_front, car.rear_axle / car.wheelbase()),
          axle(car.cornering_stiffness_rear, car.rear_axle * yaw_rate - v_y, car.grip_rear,
               car.front_axle / car.wheelbase())};
}

void expect_step_of_automatic_differentiation(const CarModel& model) {
  for (const State& state : grid_of_states()) {
    if (state.mean[at::v_x] == 0.0) continue;  // the kink of |v_x|
    for (const bool steering : {true, false}) {
      const Input input{state.front_wheels, steering};
      const DualVector x = variables<variable_count, at::size>(state.mean, 0);
      const Dual kappa(state.slow.mean[slow::stiffness_scale], variable_count, at::size);
      const DualVector after =
          next(model, input, tyres_at(model, input, state, x[at::v_x]), x, kappa);
      const Eigen::Matrix<double, at::size, variable_count> J =
          jacobian<variable_count, at::size>(after);

      const LinearStep step = linear_step(model, input, dt, state);
      const double scale = 1.0 + J.cwiseAbs().maxCoeff();
      EXPECT_LT((step.mean - values<variable_count, at::size>(after)).norm(), 1e-11)
          << state.mean.transpose();
      EXPECT_LT(largest(step.F - J.leftCols<at::size>()), 1e-11 * scale) << state.mean.transpose();
      EXPECT_LT(largest(step.by_slow.col(slow::stiffness_scale) - J.col(at::size)), 1e-11 * scale);
      for (Eigen::Index i = 0; i < slow::size; ++i) {
        EXPECT_TRUE(i == slow::stiffness_scale || i == slow::softness ||
                    step.by_slow.col(i).isZero(0.0))
            << i;
      }
    }
  }
}

TEST(Process, StepAndJacobianMatchAutomaticDifferentiation) {
  expect_step_of_automatic_differentiation({});
}

TEST(Process, StepAndJacobianAreRightForSaturatingTyres) {
  // Model and Jacobian are implicit in v_y and ψ̇, with the secant stiffness held as at the step's
  // start.
  CarModel model;
  model.car.grip_front = 7.0;
  model.car.grip_rear = 9.0;
  expect_step_of_automatic_differentiation(model);
}

TEST(Process, WithoutSteeringItsOffsetHasNoEffect) {
  State state = grid_of_states().back();
  EXPECT_NEAR(moving(state, {0.3, true}).front_wheel, 0.3 - 0.01 + 0.1, 1e-15);
  EXPECT_NEAR(moving(state, {0.3, false}).front_wheel, 0.1, 1e-15);
  EXPECT_NEAR(moving(state, {0.3, false}).stiffness, 0.8, 1e-15);
}

TEST(Process, CovarianceIsPropagatedWithTheFullJacobian) {
  const CarModel model;
  for (State state : grid_of_states()) {
    const Input input{state.front_wheels, true};
    state.slow = some_slow_errors();
    const LinearStep step = linear_step(model, input, dt, state);
    state.covariance = some_covariance();
    const State before = state;
    propagate(model, input, dt, state);
    const Matrix expected = step.F * before.covariance * step.F.transpose() + step.noise;
    const double scale = 1.0 + step.F.norm();
    EXPECT_LT(largest(state.covariance - expected), 1e-12 * scale);
    EXPECT_EQ(state.covariance, state.covariance.transpose());
    EXPECT_EQ(Matrix(step.noise.diagonal().asDiagonal()), step.noise);
    EXPECT_GE(step.noise.diagonal().minCoeff(), 0.0);
    EXPECT_EQ(step.noise(at::x, at::x), step.noise(at::y, at::y));
    EXPECT_LT(largest(state.slow.sensitivity - step.F * before.slow.sensitivity - step.by_slow),
              1e-12 * scale);
    EXPECT_EQ(state.slow.mean, before.slow.mean);
  }
}

TEST(Process, NoiseIsADensity) {
  // Ten steps of 0.2 ms give the covariance of one step of 2 ms, except for the path's curvature.
  const CarModel model;
  const Input input{0.1, true};
  State coarse;
  coarse.mean[at::v_x] = 2.0;
  coarse.covariance = Matrix::Identity() * 1e-4;
  State fine = coarse;
  propagate(model, input, 0.002, coarse);
  for (int i = 0; i < 10; ++i) propagate(model, input, 0.0002, fine);
  for (Eigen::Index i = 0; i < at::size; ++i) {
    const double expected = coarse.covariance(i, i);
    EXPECT_NEAR(fine.covariance(i, i), expected, 0.08 * expected) << i;
  }
}

TEST(Process, GaussMarkovErrorsReachTheirStationaryVariance) {
  // Gauss-Markov processes reach their stationary variance after a while, at any period.
  for (const double period_s : {0.001, 0.02}) {
    CarModel model;
    State state;
    state.mean[at::v_x] = 2.0;
    state.drive_noise_scale = 4.0;
    state.turn_noise_scale = 0.25;
    for (double t = 0.0; t < 10.0; t += period_s) {
      propagate(model, {0.0, true}, period_s, state);
      state.covariance.topRows<6>().setZero();
      state.covariance.leftCols<6>().setZero();
    }
    EXPECT_NEAR(std::sqrt(state.covariance(at::accel_x, at::accel_x)),
                2.0 * model.tuning.drive_accel * gravity, 1e-3);
    EXPECT_NEAR(std::sqrt(state.covariance(at::front_angle, at::front_angle)),
                0.5 * model.tuning.front_angle, 1e-3);
  }
}

TEST(Process, TyreModelErrorGrowsWithTheCubeOfTheForce) {
  CarModel model;
  double softness_sigma = model.tuning.softness;
  const auto grown = [&](double side_accel) {
    State state;
    state.time_ns = state.reading(Source::camera).fused_ns = 1;  // the speed is known
    state.variance(slow::softness) = softness_sigma * softness_sigma;
    state.mean[at::v_x] = 10.0;
    state.mean[at::yaw_rate] = side_accel / 10.0;
    propagate(model, {0.0, true}, 0.005, state);
    EXPECT_NEAR(std::sqrt(state.variance(at::v_y) / 0.005), model.tuning.side_slip_floor * gravity,
                1e-3);
    // e with the variance V acts like white noise of v̇_y with the density 2 T V.
    const double T = model.tuning.side_force_s;
    const double decay = T / (T + 0.005);
    return 2.0 * T *
           (state.variance(at::side_force) / (1.0 - decay * decay) -
            squared(model.tuning.side_force * side_accel));
  };
  const double straight = grown(0.0);
  // The noise uses the yaw rate after the step, which is a little smaller.
  EXPECT_NEAR(std::sqrt(grown(gravity) - straight), model.tuning.side_slip * gravity, 0.15);
  EXPECT_NEAR(std::sqrt(grown(0.5 * gravity) - straight), model.tuning.side_slip * gravity / 8.0,
              0.02);
  // The model error of a known tyre is smaller. High grip keeps the stiffness.
  const double unknown = grown(gravity) - straight;
  softness_sigma = 0.0;
  EXPECT_NEAR(std::sqrt((grown(gravity) - straight) / unknown), model.tuning.side_slip_grip, 0.02);
  softness_sigma = model.tuning.softness;
  model.car.grip_rear = 1e6;
  EXPECT_NEAR(std::sqrt((grown(gravity) - straight) / unknown), model.tuning.side_slip_grip, 0.02);
}

TEST(Process, AtStandstillOnlyRandomWalksGrow) {
  State state = grid_of_states().back();
  state.covariance = some_covariance();
  state.slow = some_slow_errors();
  const State before = state;
  propagate_standing({}, 2.0, state);
  EXPECT_EQ(state.mean, before.mean);
  EXPECT_EQ(state.slow.sensitivity, before.slow.sensitivity);
  Matrix grown = state.covariance - before.covariance;
  const Tuning t;
  EXPECT_NEAR(grown(at::accel_bias_x, at::accel_bias_x), 2.0 * squared(t.accel_bias_walk), 1e-12);
  EXPECT_NEAR(grown(at::steering_offset, at::steering_offset),
              2.0 * squared(t.steering_offset_walk), 1e-12);
  grown.bottomRightCorner<3, 3>().diagonal().setZero();
  EXPECT_TRUE(grown.isZero(0.0));
  const SlowMatrix slow_growth = state.slow.covariance - before.slow.covariance;
  EXPECT_NEAR(slow_growth(slow::gyro_bias, slow::gyro_bias), 2.0 * std::pow(t.gyro_bias_walk, 2),
              1e-12);
}

TEST(BrushTyre, IsLinearAtSmallSlip) {
  EXPECT_EQ(secant_stiffness(20.0, 0.3, 0.0, 1.5).stiffness, 20.0);  // unlimited grip: any α
  EXPECT_EQ(secant_stiffness(20.0, 0.0, 1.0 / 9.0, 1.5).stiffness, 20.0);
  EXPECT_NEAR(secant_stiffness(20.0, 1e-6, 1.0 / 9.0, 1.5).stiffness, 20.0, 1e-4);
}

TEST(BrushTyre, ForceIsThatOfItsFormulaAndNeverFalls) {
  const double most = 9.0 * 1.5;
  const double sliding = 3.0 * most / 20.0;  // q = 1
  const auto pushes = [](double alpha) {
    return secant_stiffness(20.0, alpha, 1.0 / 9.0, 1.5).stiffness * alpha;
  };
  for (double alpha = 0.01; alpha < 2.0 * sliding; alpha += 0.01) {
    EXPECT_GE(pushes(alpha), pushes(alpha - 0.01) - 1e-12) << alpha;
    EXPECT_NEAR(pushes(alpha), alpha * secant(20.0, alpha, most, Dual(1.0)).value(), 1e-12)
        << alpha;
    EXPECT_EQ(pushes(-alpha), -pushes(alpha)) << alpha;
  }
  for (const double alpha : {sliding, 1.5 * sliding, 40.0}) EXPECT_NEAR(pushes(alpha), most, 1e-12);
}

TEST(BrushTyre, ItsDerivativesByTheSoftnessAreThoseOfDifferences) {
  constexpr double h = 1e-6;
  for (const double alpha : {0.01, 0.3, 0.9, 3.0}) {
    const auto stiffness = [alpha](double softness) {
      return secant_stiffness(20.0, alpha, softness, 1.5).stiffness;
    };
    for (const double softness : {0.02, 0.1, 0.4}) {
      EXPECT_NEAR(secant_stiffness(20.0, alpha, softness, 1.5).by_softness,
                  (stiffness(softness + h) - stiffness(softness - h)) / (2.0 * h), 1e-3);
    }
  }
  const Vehicle car;
  for (const double v_y : {-0.6, 0.02, 0.4}) {
    const auto at = [&](double softness) {
      return velocity_step(car,
                           {.v_x = 2.0,
                            .v_y = v_y,
                            .yaw_rate = 1.2,
                            .accel_x = 0.5,
                            .front_wheel = 0.2,
                            .stiffness = 0.9,
                            .softness = softness},
                           dt);
    };
    const Eigen::Vector2d by =
        (at(0.03 + h).velocity - at(0.03 - h).velocity).tail<2>() / (2.0 * h);
    EXPECT_LT((at(0.03).by_softness - by).norm(), 1e-5 * (1.0 + by.norm())) << v_y;
  }
}

}  // namespace
}  // namespace odomd::estimator::full::testing::process_model_test
