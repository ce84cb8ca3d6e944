#include "tools/init/sensor_noise.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "tools/identify/common/quantisation.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

double two_digits(double value) {
  return std::stod(fmt::format("{:.2g}", value));
}

struct Range {
  double least, most;
};

/// Which sigmas a filter can use: below, the model's own errors are larger.
Range range_of(Source role) {
  if (role == Source::yaw_rate) return {0.005, 0.05};
  if (role == Source::accel_x || role == Source::accel_y) return {0.3, 2.0};
  return {0.02, 0.1};
}

/// The mean of all samples taken while the wheels stand.
std::optional<double> bias_standing(const Series& signal, const Series& wheel) {
  constexpr std::size_t enough = 50;
  constexpr double still = 0.01;                // m/s
  constexpr std::int64_t margin = 500'000'000;  // ns around a motion
  double sum = 0.0;
  std::size_t count = 0, w = 0;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    while (w < wheel.size() && wheel.t_ns[w] < signal.t_ns[i] - margin) ++w;
    bool stands = w > 0;
    for (std::size_t k = w; k < wheel.size() && wheel.t_ns[k] <= signal.t_ns[i] + margin; ++k)
      stands = stands && std::fabs(wheel.value[k]) < still;
    if (!stands) continue;
    sum += signal.value[i];
    ++count;
  }
  if (count < enough) return std::nullopt;
  return sum / static_cast<double>(count);
}

const Series* any_speed(const Proposal& proposal) {
  for (const Source role : wheel_sources)
    if (proposal.has(role)) return &proposal.of(role)->series;
  return nullptr;
}

}  // namespace

void set_noise(Proposal& proposal) {
  for (std::size_t i = 0; i < estimator::index_of(Source::steering); ++i) {
    auto& choice = proposal.roles.at(i);
    if (!choice || choice->series.size() < 20) continue;
    const double noise = std::max(white_sigma(choice->series), resolution_of(choice->series.value));
    const auto [least, most] = range_of(static_cast<Source>(i));
    choice->sigma = two_digits(std::clamp(noise, least, most));
    choice->reasons.emplace_back("sigma from the log");
  }
  const Series* speed = any_speed(proposal);
  auto& gyro = proposal.of(Source::yaw_rate);
  if (speed == nullptr || !gyro) return;
  constexpr double worth_a_word = 0.001;  // rad/s
  if (const auto bias = bias_standing(gyro->series, *speed);
      bias && std::fabs(*bias) > worth_a_word) {
    gyro->offset = -std::round(1e5 * *bias) / 1e5;
    gyro->reasons.emplace_back("offset: its bias while the car stands");
  }
}

}  // namespace odomd::tools
