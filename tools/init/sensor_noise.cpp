#include "tools/init/drive_course.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "tools/identify/common/measured.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

double two_digits(double value) {
  return std::stod(fmt::format("{:.2g}", value));
}

struct Range {
  double least, most;
};

/// The range of sigmas that a filter can use; below it the errors of its model are larger.
Range range_of(Source role) {
  if (role == Source::yaw_rate) return {0.005, 0.05};
  if (role == Source::accel_x || role == Source::accel_y) return {0.3, 2.0};
  return {0.02, 0.1};
}

/// Whether a wheel is at rest from the margin before a time to the margin after; times must rise.
class Rest {
 public:
  explicit Rest(const Series& wheel) : wheel_(&wheel) {}
  [[nodiscard]] bool holds_at(std::int64_t t_ns) {
    constexpr double still = 0.01;                // m/s
    constexpr std::int64_t margin = 750'000'000;  // ns
    while (from_ < wheel_->size() && wheel_->t_ns[from_] < t_ns - margin) ++from_;
    bool stands = from_ > 0;
    std::size_t k = from_;
    for (; k < wheel_->size() && wheel_->t_ns[k] <= t_ns + margin; ++k)
      stands = stands && std::fabs(wheel_->value[k]) < still;
    return stands && k > from_ && k < wheel_->size();
  }

 private:
  const Series* wheel_;
  std::size_t from_ = 0;
};

/// The mean reading while all wheels are at rest, without outliers; none if the car still turns.
std::optional<double> bias_standing(const Series& signal, const Proposal& proposal) {
  constexpr std::size_t enough = 50;
  constexpr double quiet = 0.02;  // rad/s: the readings of a creeping car scatter more
  std::vector<Rest> wheels;
  for (const Source role : wheel_sources)
    if (proposal.has(role)) wheels.emplace_back(proposal.of(role)->series);
  std::vector<double> values;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    bool stands = !wheels.empty();
    for (Rest& wheel : wheels) stands = wheel.holds_at(signal.t_ns[i]) && stands;
    if (stands) values.push_back(signal.value[i]);
  }
  if (values.size() < enough) return std::nullopt;
  const double middle = median_of(values);
  std::vector<double> off;
  for (const double value : values) off.push_back(value - middle);
  const double spread = median_of_magnitudes(off);
  if (spread > quiet) return std::nullopt;
  const double bound = std::max(4.0 * spread, std::min(resolution_of(values), quiet));
  double sum = 0.0, count = 0.0;
  for (const double value : off)
    if (std::fabs(value) <= bound) sum += value, ++count;
  return middle + sum / count;
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
  auto& gyro = proposal.of(Source::yaw_rate);
  if (!gyro) return;
  constexpr double worth_a_word = 0.001, far_off = 0.035;  // rad/s
  if (const auto bias = bias_standing(gyro->series, proposal);
      bias && std::fabs(*bias) > worth_a_word) {
    gyro->offset = -std::round(1e5 * *bias) / 1e5;
    gyro->reasons.emplace_back("offset: its bias while the car stands");
    if (std::fabs(*bias) > far_off)
      gyro->warnings.push_back(fmt::format(
          "a bias of {:.2g} rad/s is large: did the car stand wherever the wheels read 0?", *bias));
  }
}

}  // namespace odomd::tools
