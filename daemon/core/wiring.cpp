#include "daemon/core/wiring.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "daemon/core/wiring_causes.hpp"
#include "estimator/common/tuning.hpp"

namespace odomd::daemon {
namespace {

using namespace wiring;
using estimator::source_count;

constexpr std::int64_t piece_ns = 500'000'000;
constexpr double piece_s = 0.5;
constexpr double memory = 20.0;             // pieces
constexpr double fewest = 10.0;             // pieces, counted with their weights
constexpr int decisions_needed = 4;         // consecutive decisions with the same result
constexpr int decisions_if_ambiguous = 20;  // the same, if other causes are nearly as likely
constexpr int most_cost = 100;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double least_backwards = 0.05;     // above the noise of a stationary wheel [m/s]
constexpr double slow = 0.1;                 // smallest compared Froude number v / √(g l)
constexpr double faster_than_reverse = 0.5;  // the same for wheel speeds without a sign
constexpr double slip_angle = 0.1;           // at which tyres begin to slide [rad]
constexpr double dry_road = 6.0;             // acceleration below which tyres hardly slide [m/s²]
constexpr double impossible = 20.0;          // [m/s²]
constexpr int pieces_of_calm = 4;
constexpr double most_gap = 0.03;  // relative gap of the axles' speeds due to unequal radii

double mean(double sum, double weights) {
  return weights > 0.0 ? sum / weights : nan;
}

// The median of the ordered speeds. When the two middle speeds have opposite signs, as when both
// wheels of one side are reversed, assumes that the car drives forwards: it seldom reverses.
double middle(std::span<const double> speeds) {
  if (speeds.empty()) return nan;
  const double low = speeds[(speeds.size() - 1) / 2], high = speeds[speeds.size() / 2];
  const bool opposite = low < -least_backwards && high > least_backwards;
  return 0.5 * (opposite ? high - low : high + low);
}

// The lateral or longitudinal acceleration above which the tyres of an axle may slide [m/s²].
double most_gentle(const estimator::Vehicle& car) {
  const double front = car.cornering_stiffness_front / car.rear_axle,
               rear = car.cornering_stiffness_rear / car.front_axle;
  return std::min(slip_angle * car.wheelbase() / car.mass * std::min(front, rear), dry_road);
}

// The median speed of the sources in `which`.
double middle_speed(const std::array<double, source_count>& values, std::uint32_t which) {
  std::array<double, wheel_sources.size()> speeds{};
  std::size_t count = 0;
  for (const Source wheel : wheel_sources) {
    const double value = values[index_of(wheel)];
    if (std::isnan(value) || !contains(which, wheel)) continue;
    double* const end = speeds.data() + count++;
    double* const place = std::upper_bound(speeds.data(), end, value);
    std::move_backward(place, end, end + 1);
    *place = value;
  }
  return middle({speeds.data(), count});
}

}  // namespace

Wiring::Wiring(const estimator::Vehicle& vehicle) noexcept
    : vehicle_(vehicle), gentle_(most_gentle(vehicle)) {}

Wiring::Piece* Wiring::piece_at(std::int64_t time_ns) noexcept {
  const std::int64_t number = time_ns / piece_ns;
  if (first_open_ == 0) first_open_ = number;
  if (number < first_open_ || number >= first_open_ + static_cast<std::int64_t>(open_pieces))
    return nullptr;
  return &open_[static_cast<std::size_t>(number) % open_pieces];
}

void Wiring::add_sample(Source source, std::int64_t time_ns, double value) noexcept {
  Piece* const piece = piece_at(time_ns);
  if (piece == nullptr || !std::isfinite(value)) return;
  const double phase =
      (static_cast<double>(time_ns % piece_ns) + 0.5) / static_cast<double>(piece_ns);
  piece->rising[index_of(source)].add(value, phase);
  piece->falling[index_of(source)].add(value, 1.0 - phase);
}

void Wiring::add_pose(const estimator::CameraPose& pose) noexcept {
  Piece* const piece = piece_at(pose.capture_ns);
  if (piece == nullptr) return;
  // Averages the heading relative to the first one, so that a wrap of 2π does not matter.
  if (piece->poses == 0) piece->pose[2] = pose.yaw;
  ++piece->poses;
  const double part = 1.0 / piece->poses;
  piece->pose[0] += part * (pose.x - piece->pose[0]);
  piece->pose[1] += part * (pose.y - piece->pose[1]);
  piece->pose[2] += part * std::remainder(pose.yaw - piece->pose[2], 2.0 * std::numbers::pi);
}

void Wiring::update(std::int64_t now_ns) noexcept {
  if (first_open_ == 0) return;
  // A sample may be half a second late.
  const std::int64_t last = now_ns / piece_ns - 2;
  // Do not wait for a first sample with a stamp in the future.
  if (first_open_ > last + static_cast<std::int64_t>(open_pieces)) {
    open_ = {};
    first_open_ = last + 1;
  }
  for (std::size_t k = 0; k < open_pieces && first_open_ <= last; ++k, ++first_open_) {
    Piece& piece = open_[static_cast<std::size_t>(first_open_) % open_pieces];
    close(piece);
    piece = {};
  }
  if (first_open_ <= last) {
    first_open_ = last + 1;
    last_ = {};
  }
}

void Wiring::close(const Piece& piece) noexcept {
  Means now;
  for (std::size_t source = 0; source < source_count; ++source) {
    const Sum &rising = piece.rising[source], &falling = piece.falling[source];
    now.of[source] = mean(rising.of + falling.of, rising.weights + falling.weights);
    now.rising[source] = mean(rising.of, rising.weights);
    now.falling[source] = mean(falling.of, falling.weights);
    if (!std::isnan(now.of[source])) heard_ |= 1U << source;
  }
  now.pose = piece.pose;
  if (piece.poses == 0) now.pose.fill(nan);
  if (piece.poses > 0) heard_ |= bits(camera);
  give_signs(now);
  now.speed = middle_speed(now.of, all_wheels);
  const double slowest = (speed_has_sign_ ? slow : faster_than_reverse) *
                         std::sqrt(estimator::gravity * vehicle_.wheelbase());
  if (std::min(std::abs(now.speed), std::abs(last_.speed)) >= slowest) {
    compare(last_, now);
    decide();
  }
  last_ = now;
}

// Speeds without a sign get it from `direction`, or from speeds that have had both signs.
void Wiring::give_signs(Means& now) noexcept {
  for (const Source wheel : wheel_sources) {
    if (now.of[index_of(wheel)] > least_backwards) ever_ahead_ |= only(wheel);
    if (now.of[index_of(wheel)] < -least_backwards) ever_back_ |= only(wheel);
  }
  const double gear = now.of[index_of(direction)];
  const double signed_speed = middle_speed(now.of, ever_ahead_ & ever_back_);
  if (std::abs(gear) > 0.0 || ever_back_ != 0) speed_has_sign_ = true;
  if (!(gear < 0.0) && !(signed_speed < -least_backwards)) return;
  for (const Source wheel : wheel_sources) {
    if (!(gear < 0.0) && contains(ever_back_, wheel)) continue;
    for (auto* const means : {&now.of, &now.rising, &now.falling}) {
      double& v = (*means)[index_of(wheel)];
      v = -std::abs(v);
    }
  }
}

void Wiring::compare(const Means& before, const Means& now) noexcept {
  // The mean over both pieces, with the highest weight in the middle: a rate enters the difference
  // of two means with these weights. With equal weights, the mean of an oscillation at 1.2 Hz would
  // have the wrong sign.
  const auto value_of = [&](Source source) {
    return 0.5 * (before.rising[index_of(source)] + now.falling[index_of(source)]);
  };
  const double l = vehicle_.wheelbase(), track = vehicle_.track_width;
  const double v = 0.5 * (before.speed + now.speed);
  std::array<double, quantity_count> q{};
  q[turn_gyro] = value_of(yaw_rate);
  q[turn_steering] = v * value_of(steering) / l;
  q[turn_camera] = std::remainder(now.pose[2] - before.pose[2], 2.0 * std::numbers::pi) / piece_s;
  q[curve_gyro] = track * q[turn_gyro] / v;
  q[curve_steering] = track * value_of(steering) / l;
  q[curve_front] = (value_of(wheel_front_right) - value_of(wheel_front_left)) / v;
  q[curve_rear] = (value_of(wheel_rear_right) - value_of(wheel_rear_left)) / v;
  q[lateral_gyro] = v * q[turn_gyro];
  q[lateral_steering] = v * q[turn_steering];
  q[side] = value_of(accel_y);
  q[ahead] = value_of(accel_x);
  q[faster] = (now.speed - before.speed) / piece_s;
  for (const Source wheel : wheel_sources) q[quantity_of(wheel)] = value_of(wheel);
  q[speed] = v;
  q[speed_camera] = std::copysign(
      std::hypot(now.pose[0] - before.pose[0], now.pose[1] - before.pose[1]) / piece_s, v);
  const double front = value_of(wheel_front_left) + value_of(wheel_front_right);
  const double rear = value_of(wheel_rear_left) + value_of(wheel_rear_right);
  q[axle_gap] = front / rear - 1.0;
  const double bend = l * q[turn_gyro] / v;
  q[axle_bend] = 0.5 * bend * bend;
  // In a piece with high accelerations the tyres slip, and drivers countersteer for longer than the
  // slide is visible.
  const auto violent = [&](Quantity of) {
    return std::abs(q[of]) > gentle_ && std::abs(q[of]) < impossible;
  };
  calm_ = violent(lateral_gyro) || violent(side) || violent(faster) ? 0 : calm_ + 1;
  spun_ = std::abs(q[axle_gap]) > most_gap + q[axle_bend] ? 0 : spun_ + 1;
  // If wheels agree within each axle but not between the axles, an axle slips as a whole, and which
  // one has the car's speed is unknown. A single wrong wheel changes left - right and
  // front - rear equally.
  const double difference =
      std::max(std::abs(q[curve_front]), std::abs(q[curve_rear])) * std::abs(v);
  const bool axle_slips = spun_ == 0 && difference < 0.5 * std::abs(front - rear);
  const std::uint32_t unknown = (calm_ == 0 || spun_ < pieces_of_calm ? by_slip : 0U) |
                                (calm_ < pieces_of_calm ? by_steering : 0U) |
                                (axle_slips ? by_speed : 0U);
  for (std::size_t i = 0; i < quantity_count; ++i)
    if ((unknown >> i & 1U) != 0) q[i] = nan;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double a = q[pairs[i].a], b = q[pairs[i].b];
    if (std::isfinite(a) && std::isfinite(b)) pairs_[i].add(a, b, pairs[i].bounds, memory);
  }
}

// A diagnosis is kept until it is contradicted. Then the one or two causes that explain all
// observations at the lowest cost replace it, or several alternatives if their costs are equal.
void Wiring::decide() noexcept {
  std::array<Seen, pair_count> seen{};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Moments::Squares squares = pairs_[i].squares(pairs[i].bounds);
    seen[i] = {pairs_[i].shows(pairs[i].bounds, fewest), squares.correlation(), squares.gain()};
  }
  const auto contradicted = [&seen](const Causes& together) {
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (fit(together, pairs[i], seen[i]) == Fit::contradicts) return true;
    return false;
  };
  // Whether the first cause explains something that the second alone does not.
  const auto explains = [&seen](std::uint8_t one, std::uint8_t other) {
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (fit({one, other}, pairs[i], seen[i]) == Fit::fits &&
          fit({nothing, other}, pairs[i], seen[i]) == Fit::contradicts)
        return true;
    return false;
  };

  Diagnosis candidate{.count = 0};
  for (std::size_t i = 0; i < diagnosis_.count; ++i)
    if (!contradicted(diagnosis_.causes[i]))
      candidate.causes[candidate.count++] = diagnosis_.causes[i];
  bool ambiguous = false;
  if (candidate.count == 0 && !contradicted({nothing, nothing})) {
    candidate = {};
  } else if (candidate.count == 0) {
    int least = most_cost;
    for (std::uint8_t one = 0; one < nothing; ++one) {
      for (std::uint8_t other = one + 1; other <= nothing; ++other) {
        const int cost = causes[one].cost + (other == nothing ? 0 : causes[other].cost + 1);
        if (cost > least + 1 || exclude(one, other) || contradicted({one, other}) ||
            !explains(one, other) || (other != nothing && !explains(other, one)))
          continue;
        ambiguous = least < most_cost && cost >= least - 1;
        if (cost < least) candidate = {.count = 0};
        if (cost <= least && candidate.count < candidate.causes.size())
          candidate.causes[candidate.count++] = {one, other};
        least = std::min(least, cost);
      }
    }
    if (candidate.count == 0) candidate = diagnosis_;
  }
  equal_decisions_ = candidate == diagnosis_ ? 0 : candidate == pending_ ? equal_decisions_ + 1 : 1;
  pending_ = candidate;
  if (equal_decisions_ < (ambiguous ? decisions_if_ambiguous : decisions_needed)) return;
  diagnosis_ = candidate;
  equal_decisions_ = 0;
  faults_.fill(WiringFault::none);
  for (std::size_t i = 0; i < diagnosis_.count; ++i)
    for (const std::uint8_t cause : diagnosis_.causes[i])
      for (std::size_t source = 0; source < source_count; ++source)
        if (cause != nothing && ((causes[cause].sources & heard_) >> source & 1U) != 0)
          faults_[source] = causes[cause].fault;
}

}  // namespace odomd::daemon
