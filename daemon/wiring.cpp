#include "daemon/wiring.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "daemon/wiring_causes.hpp"

namespace odomd::daemon {
namespace {

using namespace wiring;
using estimator::source_count;

constexpr std::int64_t piece_ns = 500'000'000;
constexpr double piece_s = 0.5;
constexpr double memory = 20.0;            // pieces
constexpr double fewest = 10.0;            // pieces, as they are remembered
constexpr int looks_needed = 4;            // that say the same
constexpr int looks_where_ambiguous = 20;  // ... where others are nearly as likely
constexpr int most_cost = 100;
constexpr double gravity = 9.81;  // [m/s²]
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double least_backwards = 0.05;     // no noise of a wheel that stands [m/s]
constexpr double slow = 0.1;                 // Froude numbers v / √(g l)
constexpr double faster_than_reverse = 0.5;  // of wheels that know no sign
constexpr double gentle_driving = 1.5;       // [m/s²]

double mean(double sum, std::uint32_t count) {
  return count == 0 ? nan : sum / count;
}

}  // namespace

Wiring::Wiring(const estimator::Vehicle& vehicle) noexcept : vehicle_(vehicle) {}

Wiring::Piece* Wiring::piece_at(std::int64_t time_ns) noexcept {
  const std::int64_t number = time_ns / piece_ns;
  if (first_open_ == 0) first_open_ = number;
  if (number < first_open_ || number >= first_open_ + static_cast<std::int64_t>(open_pieces))
    return nullptr;
  return &open_[static_cast<std::size_t>(number) % open_pieces];
}

void Wiring::hear(Source source, std::int64_t time_ns, double value) noexcept {
  Piece* const piece = piece_at(time_ns);
  if (piece == nullptr || !std::isfinite(value)) return;
  piece->sum[index_of(source)] += value;
  ++piece->count[index_of(source)];
}

void Wiring::hear(const estimator::CameraPose& pose) noexcept {
  Piece* const piece = piece_at(pose.capture_ns);
  if (piece == nullptr) return;
  // The heading about that of the first, which no turn of it is between.
  if (piece->poses == 0) piece->pose[2] = pose.yaw;
  ++piece->poses;
  const double part = 1.0 / piece->poses;
  piece->pose[0] += part * (pose.x - piece->pose[0]);
  piece->pose[1] += part * (pose.y - piece->pose[1]);
  piece->pose[2] += part * std::remainder(pose.yaw - piece->pose[2], 2.0 * std::numbers::pi);
}

void Wiring::look(std::int64_t now_ns) noexcept {
  if (first_open_ == 0) return;
  // A sample may be half a second late.
  const std::int64_t last = now_ns / piece_ns - 2;
  // A first sample from the future must not be waited for.
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
    now.of[source] = mean(piece.sum[source], piece.count[source]);
    if (piece.count[source] > 0) heard_ |= 1U << source;
  }
  now.pose = piece.pose;
  if (piece.poses == 0) now.pose.fill(nan);
  if (piece.poses > 0) heard_ |= bits(camera);

  std::array<double, last_wheel - first_wheel + 1> speeds_told{};
  std::size_t count = 0;
  const double gear = now.of[index_of(direction)];
  if (std::abs(gear) > 0.0) speed_has_sign_ = true;
  for (std::size_t wheel = index_of(wheel_front_left); wheel <= index_of(motor); ++wheel) {
    double& v = now.of[wheel];
    if (gear < 0.0) v = -std::abs(v);
    if (v < -least_backwards) speed_has_sign_ = true;
    if (std::isnan(v)) continue;
    double* const end = speeds_told.data() + count++;
    double* const place = std::upper_bound(speeds_told.data(), end, v);
    std::move_backward(place, end, end + 1);
    *place = v;
  }
  now.speed = nan;
  if (count > 0) {
    now.speed = 0.5 * (speeds_told[(count - 1) / 2] + speeds_told[count / 2]);
  }
  const double slowest =
      (speed_has_sign_ ? slow : faster_than_reverse) * std::sqrt(gravity * vehicle_.wheelbase());
  if (std::min(std::abs(now.speed), std::abs(last_.speed)) >= slowest) {
    compare(last_, now);
    decide();
  }
  last_ = now;
}

void Wiring::compare(const Means& before, const Means& now) noexcept {
  const auto told = [&](Source source) {
    return 0.5 * (before.of[index_of(source)] + now.of[index_of(source)]);
  };
  const double l = vehicle_.wheelbase(), track = vehicle_.track_width;
  const double v = 0.5 * (before.speed + now.speed);
  std::array<double, quantity_count> q{};
  q[turn_gyro] = told(yaw_rate);
  q[turn_steering] = v * told(steering) / l;
  q[turn_camera] = std::remainder(now.pose[2] - before.pose[2], 2.0 * std::numbers::pi) / piece_s;
  q[curve_gyro] = track * q[turn_gyro] / v;
  q[curve_steering] = track * told(steering) / l;
  q[curve_front] = (told(wheel_front_right) - told(wheel_front_left)) / v;
  q[curve_rear] = (told(wheel_rear_right) - told(wheel_rear_left)) / v;
  q[lateral_gyro] = v * q[turn_gyro];
  q[lateral_steering] = v * q[turn_steering];
  q[side] = told(accel_y);
  q[ahead] = told(accel_x);
  q[faster] = (now.speed - before.speed) / piece_s;
  for (std::size_t i = 0; i <= last_wheel - first_wheel; ++i)
    q[first_wheel + i] = told(static_cast<Source>(index_of(wheel_front_left) + i));
  q[speed] = v;
  q[speed_camera] = std::copysign(
      std::hypot(now.pose[0] - before.pose[0], now.pose[1] - before.pose[1]) / piece_s, v);
  const double front = told(wheel_front_left) + told(wheel_front_right);
  const double rear = told(wheel_rear_left) + told(wheel_rear_right);
  const bool gentle = std::max(std::abs(q[lateral_gyro]), std::abs(q[faster])) < gentle_driving;
  q[axle_gap] = gentle ? front / rear - 1.0 : nan;
  const double bend = l * q[turn_gyro] / v;
  q[axle_bend] = 0.5 * bend * bend;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double a = q[pairs[i].a], b = q[pairs[i].b];
    if (std::isfinite(a) && std::isfinite(b)) pairs_[i].add(a, b, memory);
  }
}

// What is believed stays until it is contradicted. Then: what explains all that is seen at the
// least cost, one cause or two; several of one cost, where none can be told from the other.
void Wiring::decide() noexcept {
  std::array<Seen, pair_count> seen{};
  for (std::size_t i = 0; i < pairs.size(); ++i)
    seen[i] = {.shows = pairs_[i].shows(pairs[i].bounds, fewest),
               .correlation = pairs_[i].correlation(pairs[i].bounds),
               .gain = pairs_[i].gain(pairs[i].bounds)};
  const auto contradicted = [&seen](const Causes& causes) {
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (fit(causes, pairs[i], seen[i]) == Fit::contradicts) return true;
    return false;
  };
  // Whether the first explains something that the second alone does not.
  const auto explains = [&seen](std::uint8_t one, std::uint8_t other) {
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (fit({one, other}, pairs[i], seen[i]) == Fit::fits &&
          fit({nothing, other}, pairs[i], seen[i]) == Fit::contradicts)
        return true;
    return false;
  };

  Belief would{.count = 0};
  for (std::size_t i = 0; i < belief_.count; ++i)
    if (!contradicted(belief_.causes[i])) would.causes[would.count++] = belief_.causes[i];
  bool ambiguous = false;
  if (would.count == 0 && !contradicted({nothing, nothing})) {
    would = {};
  } else if (would.count == 0) {
    int least = most_cost;
    for (std::uint8_t one = 0; one < nothing; ++one) {
      for (std::uint8_t other = one + 1; other <= nothing; ++other) {
        const int cost = causes[one].cost + (other == nothing ? 0 : causes[other].cost + 1);
        if (cost > least + 1 || exclude(one, other) || contradicted({one, other}) ||
            !explains(one, other) || (other != nothing && !explains(other, one)))
          continue;
        ambiguous = least < most_cost && cost >= least - 1;
        if (cost < least) would = {.count = 0};
        if (cost <= least && would.count < would.causes.size())
          would.causes[would.count++] = {one, other};
        least = std::min(least, cost);
      }
    }
    if (would.count == 0) would = belief_;
  }
  looks_ = would == belief_ ? 0 : would == next_ ? looks_ + 1 : 1;
  next_ = would;
  if (looks_ < (ambiguous ? looks_where_ambiguous : looks_needed)) return;
  belief_ = would;
  looks_ = 0;
  faults_.fill(WiringFault::none);
  for (std::size_t i = 0; i < belief_.count; ++i)
    for (const std::uint8_t cause : belief_.causes[i])
      for (std::size_t source = 0; source < source_count; ++source)
        if (cause != nothing && ((causes[cause].sources & heard_) >> source & 1U) != 0)
          faults_[source] = causes[cause].fault;
}

}  // namespace odomd::daemon
