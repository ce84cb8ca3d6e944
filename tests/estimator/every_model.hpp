// Tests that run with every model behind the common interface.
#pragma once

#include <optional>

#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::filter_test {

using testing::Drive;
using testing::period_ns;
using testing::Samples;
using testing::start;

class EveryModel : public ::testing::TestWithParam<Model> {};

inline const auto every_model = ::testing::Values(Model::kinematic, Model::kinematic_printed,
                                                  Model::full, Model::paper, Model::inertial);
inline std::string name_of_model(const ::testing::TestParamInfo<Model>& model) {
  return std::string(model_names[static_cast<std::size_t>(model.param)]);
}

/// A slalom, with all signals of a car.
inline Samples slalom(int tick) {
  const double t = 0.005 * tick;
  const double delta = 0.25 * std::sin(2.0 * t);
  const double speed = 1.2 + 0.4 * std::sin(0.5 * t);
  return {.speed = speed,
          .steering = delta,
          .yaw_rate = speed * std::tan(delta) / 0.26,
          .accel_x = 0.2 * std::cos(0.5 * t)};
}

inline Drive slalom_for(Model model, int ticks) {
  Drive drive = start(model);
  for (int i = 0; i < ticks; ++i) drive.tick(slalom(i));
  return drive;
}

/// Fused, or left for the step to judge.
inline bool taken(std::optional<Verdict> verdict) {
  return verdict.value_or(Verdict::fused) == Verdict::fused;
}

inline void expect_same_bits(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(a.time_ns, b.time_ns);
  testing::expect_same_frames(a, b);
}

}  // namespace odomd::estimator::filter_test
