// The published part of the state, the state that resumes from it, and the checks and limits before
// a state is published.
#include "estimator/ekf/publication.hpp"

#include <limits>

#include <Eigen/Eigenvalues>

#include "estimator/common/predecessor.hpp"
#include "estimator/common/symmetric3.hpp"
#include "states.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::publication_test {
namespace {

constexpr Symmetric3 diagonal(double a, double b, double c) {
  return {a, 0.0, 0.0, b, 0.0, c};
}

State fresh() {
  return initial_state({});
}

Estimate published(const State& state, double period_s = 0.005, const Input& input = {}) {
  return publication({}, input, period_s, state, fresh());
}

Estimate predecessor() {
  Estimate e;
  e.initialised = true;
  e.map = {3.0, -1.0, 0.4};
  e.v_x = 2.0;
  e.v_y = -0.1;
  e.yaw_rate = 0.5;
  e.covariance = diagonal(1e-4, 4e-4, 1e-5);
  e.velocity_covariance = {1e-3, 2e-4, 1e-5, 4e-3, -3e-5, 9e-4};
  e.camera_ns = 123;
  return e;
}

Symmetric3 of_velocity(const State& state) {
  return packed(state.covariance.block<3, 3>(at::v_x, at::v_x));
}

TEST(Resumed, GrowsTheVelocityCovarianceOverTheGap) {
  // The car may have braked or steered since.
  const Symmetric3 grown = of_velocity(resumed({}, predecessor(), 0.5, fresh()));
  EXPECT_NEAR(grown[0], 1e-3 + 1.0, 1e-12);
  EXPECT_NEAR(grown[3], 4e-3 + 1.0, 1e-12);
  EXPECT_NEAR(grown[5], 9e-4 + 6.25, 1e-12);
  EXPECT_EQ(grown[1], 2e-4);
}

TEST(Resumed, StartsWithItsOwnVelocityCovarianceIfThereIsNone) {
  for (const Symmetric3& given : {Symmetric3{}, diagonal(1.0, -1.0, 1.0),
                                  diagonal(std::nan(""), 1.0, 1.0), Symmetric3{1, 2, 0, 1, 0, 1}}) {
    Estimate e = predecessor();
    e.velocity_covariance = given;
    EXPECT_EQ(of_velocity(resumed({}, e, 0.0, fresh())), diagonal(1.0, 1.0, 1.0));
  }
}

TEST(Resumed, PoseUncertaintyGrowsWithTheVelocityUncertainty) {
  Estimate sure = predecessor();
  sure.velocity_covariance = diagonal(1e-12, 1e-12, 1e-12);
  Estimate doubtful = predecessor();
  doubtful.velocity_covariance = diagonal(0.09, 0.01, 0.04);
  const double gap_s = 0.5;
  const Matrix P = resumed({}, sure, gap_s, fresh()).covariance;
  const Matrix Q = resumed({}, doubtful, gap_s, fresh()).covariance;
  // τ² times the squared velocity, along the car and across
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  EXPECT_NEAR(Q(0, 0) - P(0, 0), gap_s * gap_s * (c * c * 0.09 + s * s * 0.01), 1e-9);
  EXPECT_NEAR(Q(0, 1) - P(0, 1), gap_s * gap_s * c * s * (0.09 - 0.01), 1e-9);
  EXPECT_NEAR(Q(2, 2) - P(2, 2), gap_s * gap_s * 0.04, 1e-9);
}

TEST(Publication, ASuccessorStartsWithItsPredecessorsLastEstimate) {
  const Estimate before = predecessor();
  const Estimate after = published(resumed({}, before, 0.0, fresh()));
  EXPECT_TRUE(after.initialised);
  EXPECT_EQ(after.map.x, before.map.x);
  EXPECT_EQ(after.map.yaw, before.map.yaw);
  EXPECT_EQ(after.v_y, before.v_y);
  EXPECT_EQ(after.covariance, before.covariance);
  EXPECT_EQ(after.velocity_covariance, before.velocity_covariance);
  EXPECT_EQ(after.camera_ns, before.camera_ns);
}

TEST(Publication, ThePeriodHardlyMattersToTheTimeDerivatives) {
  State state;
  state.located = state.moving = true;
  state.mean[at::v_x] = 2.0;
  state.mean[at::yaw_rate] = 0.4;
  state.mean[at::accel_x] = 0.7;
  const auto rates_at = [&](double period_s) { return published(state, period_s, {0.2, true}); };
  const Estimate usual = rates_at(0.005);
  EXPECT_GT(usual.yaw_accel, 5.0);
  for (const double period_s : {0.001, 0.0025, 0.01}) {
    const Estimate other = rates_at(period_s);
    EXPECT_NEAR(other.v_x_dot, usual.v_x_dot, 0.05) << period_s;
    EXPECT_NEAR(other.v_y_dot, usual.v_y_dot, 0.5) << period_s;
    EXPECT_NEAR(other.yaw_accel, usual.yaw_accel, 0.1 * usual.yaw_accel) << period_s;
  }
  // A period longer than the look-ahead itself.
  EXPECT_GT(rates_at(0.1).yaw_accel, 1.0);
}

TEST(Publication, CovarianceIncludesTheCamerasLatency) {
  State state = fresh();
  state.located = state.moving = true;
  state.mean.segment<6>(at::x) << 3.0, 1.0, 0.4, 20.0, -1.0, 0.5;
  const Estimate before = published(state);
  state.last_camera_pose.capture_ns = 1;
  const Estimate after = published(state);
  const double late_s = Tuning{}.camera_latency;
  const Eigen::Vector3d off = late_s * Eigen::Vector3d{20.0 * std::cos(0.4) + std::sin(0.4),
                                                       20.0 * std::sin(0.4) - std::cos(0.4), 0.5};
  const Eigen::Matrix3d grown = unpacked(after.covariance) - unpacked(before.covariance);
  EXPECT_LT((grown - off * off.transpose()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(after.velocity_covariance, before.velocity_covariance);
}

TEST(Publication, DerivativesAreZeroAtStandstill) {
  State state;
  state.located = state.moving = state.standstill.standing = true;
  state.mean[at::accel_x] = 0.7;
  const Estimate e = published(state);
  EXPECT_THAT((std::array{e.v_x_dot, e.v_y_dot, e.yaw_accel}), ::testing::Each(0.0));
}

TEST(Publication, TheCovarianceIncludesTheSlowErrors) {
  State state = resumed({}, predecessor(), 0.0, fresh());
  state.slow.sensitivity(at::yaw, slow::gyro_bias) = -10.0;
  state.slow.sensitivity(at::x, slow::gyro_bias) = 2.0;
  const double variance = fresh().slow.covariance(slow::gyro_bias, slow::gyro_bias);
  const Estimate e = published(state);
  EXPECT_NEAR(e.covariance[5], 1e-5 + 100.0 * variance, 1e-12);
  EXPECT_NEAR(e.covariance[2], -20.0 * variance, 1e-12);
  EXPECT_EQ(e.velocity_covariance, predecessor().velocity_covariance);
}

TEST(Publication, ACalibrationIsValidOnceItIsKnownClearlyBetter) {
  State state = fresh();
  EXPECT_EQ(published(state).calibration.valid, 0U);
  EXPECT_EQ(published(state).calibration.value[0], 0.0);
  state.slow.mean = SlowVector::Constant(0.01);
  state.mean.tail<3>().setConstant(0.02);  // the accelerometers' biases, the steering's offset
  const Calibration calibration = published(state).calibration;
  const double grip = 1.0 / (Tuning{}.tyre_softness + 0.01);
  const std::array<double, calibration_count> values{0.01, 1.01, 0.02, 0.02, 1.01, 0.02,
                                                     1.01, 0.01, 0.01, 0.01, grip};
  for (std::size_t i = 0; i < calibration_count; ++i)
    EXPECT_NEAR(calibration.value[i], values[i], 1e-15) << i;
  for (const double share : {0.5, 0.3}) {
    state = fresh();
    state.slow.covariance *= share * share;
    state.covariance *= share * share;
    const Calibration known = published(state).calibration;
    std::uint64_t every = 0;  // except those that are not estimated
    for (std::size_t i = 0; i < calibration_count; ++i)
      if (known.sigma[i] > 0.0) every |= std::uint64_t{1} << i;
    EXPECT_GE(every, 0b1111111U);
    EXPECT_EQ(known.valid, share < 0.4 ? every : 0U) << share;
  }
}

// Checks and limits
// ---------------------------------------------------------------------------------------

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

State some_state() {
  State state = grid_of_states().front();
  state.covariance = some_covariance();
  state.slow = some_slow_errors();
  return state;
}

TEST(IsValid, AcceptsPossibleStates) {
  for (State state : grid_of_states()) {
    state.covariance = some_covariance();
    state.slow = some_slow_errors();
    EXPECT_TRUE(is_valid(state));
  }
}

TEST(IsValid, RejectsNumbersThatAreNotFinite) {
  const auto expect_refused = [](const auto& change) {
    State state = some_state();
    change(state);
    EXPECT_FALSE(is_valid(state));
  };
  for (const double value : {nan, infinity, -infinity}) {
    for (Eigen::Index i = 0; i < at::size; ++i) {
      SCOPED_TRACE(i);
      expect_refused([&](State& s) { s.mean[i] = value; });
      for (Eigen::Index j = 0; j <= i; ++j)
        expect_refused([&](State& s) { s.covariance(i, j) = s.covariance(j, i) = value; });
      for (Eigen::Index j = 0; j < slow::size; ++j)
        expect_refused([&](State& s) { s.slow.sensitivity(i, j) = value; });
    }
    for (Eigen::Index i = 0; i < slow::size; ++i) {
      SCOPED_TRACE(i);
      expect_refused([&](State& s) { s.slow.mean[i] = value; });
      for (Eigen::Index j = 0; j <= i; ++j) {
        expect_refused(
            [&](State& s) { s.slow.covariance(i, j) = s.slow.covariance(j, i) = value; });
      }
    }
  }
}

TEST(IsValid, RejectsStatesBeyondAnyCar) {
  for (const auto& [index, value] : {std::pair{at::x, 2e9},
                                     {at::y, -2e9},
                                     {at::v_x, 301.0},
                                     {at::yaw_rate, -101.0},
                                     {at::front_angle, 2e4},
                                     {at::steering_offset, -2e4}}) {
    State state = some_state();
    state.mean[index] = value;
    EXPECT_FALSE(is_valid(state)) << index;
  }
  State state = some_state();
  state.slow.mean[slow::wheel_scale] = 2e4;
  EXPECT_FALSE(is_valid(state));
}

TEST(IsValid, RequiresPositiveEigenvalues) {
  const State state = some_state();
  const double smallest =
      Eigen::SelfAdjointEigenSolver<Matrix>(state.covariance).eigenvalues().minCoeff();
  for (const double share : {1.0 - 1e-6, 1.0 + 1e-6}) {
    State less = state;
    less.covariance.diagonal().array() -= share * smallest;
    EXPECT_EQ(is_valid(less), share < 1.0);
  }
}

TEST(Limit, ReducesVariancesAndKeepsCorrelations) {
  State state = some_state();
  Matrix& P = state.covariance;
  P = some_covariance(1e9);
  state.slow = some_slow_errors(1e6);
  const Vector before = P.diagonal();
  const double correlation = P(0, 4) / std::sqrt(P(0, 0) * P(4, 4));
  limit(state);
  EXPECT_LE(P(at::x, at::x), 1e6 * (1.0 + 1e-8));
  EXPECT_LE(P(at::yaw, at::yaw), 10.24 * (1.0 + 1e-8));
  EXPECT_LT(P(at::v_y, at::v_y), before[at::v_y]);
  EXPECT_NEAR(P(0, 4) / std::sqrt(P(0, 0) * P(4, 4)), correlation, 1e-8);
  EXPECT_TRUE(is_covariance(P));
  EXPECT_LE(state.slow.covariance.diagonal().maxCoeff(), 4.0 * (1.0 + 1e-8));
  EXPECT_TRUE(is_covariance(state.slow.covariance));
}

TEST(Limit, HardlyChangesSmallVariances) {
  State state = some_state();
  const State before = state;
  limit(state);
  const auto grown = [](const auto& after, const auto& earlier) {
    return (after.diagonal().array() > earlier.diagonal().array()).all() &&
           largest(after - earlier) < 2e-9 * earlier.cwiseAbs().maxCoeff();
  };
  EXPECT_TRUE(grown(state.covariance, before.covariance));
  EXPECT_TRUE(grown(state.slow.covariance, before.slow.covariance));
  EXPECT_EQ(state.mean, before.mean);
  EXPECT_EQ(state.slow.sensitivity, before.slow.sensitivity);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::publication_test
