#include "tools/identify/latency/latency_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tools/cli/text.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/noise_sources.hpp"
#include "tools/identify/latency/accel_latency.hpp"
#include "tools/identify/latency/gyro_drive.hpp"
#include "tools/identify/latency/offset_regression.hpp"
#include "tools/identify/latency/wheel_latency.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

double top_of(const Resampled& signal) {
  double most = 0.0;
  for (const double value : signal.value) most = std::max(most, std::fabs(value));
  return most;
}

// ψ_camera(t) = (1 + s) ∫ gyro(t - D) + b t + c
SourceOffset camera_yaw(const GyroDrive& drive, std::span<const estimator::CameraPose> camera) {
  OffsetRegression r;
  std::vector<std::pair<std::int64_t, double>> seen;
  for (const estimator::CameraPose& pose : camera) seen.emplace_back(pose.capture_ns, pose.yaw);
  std::ranges::sort(seen);
  double yaw = seen.empty() ? 0.0 : seen.front().second;
  for (const auto& [t_ns, raw] : seen) {
    const double t = drive.seconds(t_ns);
    yaw += std::remainder(raw - yaw, 2.0 * M_PI);
    if (t < drive.begin + r.range || t > drive.end - r.range) continue;
    if (!r.t.empty() && t <= r.t.back()) continue;
    r.t.push_back(t);
    r.y.push_back(yaw);
  }
  Resampled clock = drive.turned;
  for (std::size_t i = 0; i < clock.value.size(); ++i)
    clock.value[i] = clock.step * static_cast<double>(i);
  // The gyro's bias and its walk: knots every ten seconds.
  r.basis = {{drive.turned, 1.0, 0.1}, {constant(clock)}, {clock}};
  const double span = drive.end - drive.begin;
  const int knots = static_cast<int>(std::clamp(std::floor(span / 15.0) - 1.0, 0.0, 40.0));
  for (int k = 1; k <= knots; ++k) {
    Resampled bend = clock;
    const double from = span * k / (knots + 1);
    for (double& value : bend.value) value = std::max(0.0, value - from);
    r.basis.push_back({std::move(bend), 0.0, 5e-3});
  }
  const Offset found = solve(r);
  SourceOffset result = as_offset(Source::camera, "the gyro's turn", found);
  // An explained share means little for angles: require enough turns.
  if (result.failure.empty()) {
    if (top_of(drive.yaw_rate) < 0.02) result.failure = "the car does not turn";
  }
  return result;
}

}  // namespace

LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                   std::span<const estimator::CameraPose> camera,
                                   const ReportProgress& report) {
  const auto begin = [&report](const std::string& what) {
    if (report) report(what);
  };
  const Series& gyro = log.need(Source::yaw_rate);  // every latency is found against it
  GyroDrive drive{config, log, 0.0, 0.0, {}, {}};
  drive.begin = drive.seconds(gyro.t_ns.front());
  drive.end = drive.seconds(gyro.t_ns.back());
  if (drive.end - drive.begin < 10.0) {
    throw std::invalid_argument(
        "the log contains " + fixed(drive.end - drive.begin, 1) +
        " s of gyro; at least ten are needed, ten minutes with curves and stops are good");
  }
  // Unrelated poses are found and reported below.
  check_agreement(config, log, camera, {.unrelated = UnrelatedPoses::accept});
  drive.yaw_rate = drive.on_grid(gyro);
  drive.turned = integral(drive.yaw_rate);

  LatencyEstimate result;
  const auto mapped = [&](Source source) { return log.of(source).size() > 1; };
  double camera_offset = 0.0;
  bool camera_placed = false;
  if (!camera.empty()) {
    begin("yaw_rate against the camera");
    result.offsets.push_back(camera_yaw(drive, camera));
    camera_placed = result.offsets.back().failure.empty();
    camera_offset = result.offsets.back().offset;
  }
  const auto place_pairs = [&](const std::optional<FrontWheels>& front_wheels) {
    for (const auto& [left, right] :
         {std::pair{Source::wheel_front_left, Source::wheel_front_right},
          std::pair{Source::wheel_rear_left, Source::wheel_rear_right}}) {
      if (!mapped(left) || !mapped(right)) continue;
      begin(name_of(left) + " and " + name_of(right) + " against yaw_rate");
      const SourceOffset found = wheel_pair(drive, left, right, front_wheels);
      for (const Source source : {left, right}) {
        std::erase_if(result.offsets,
                      [source](const SourceOffset& old) { return old.source == source; });
        result.offsets.push_back(found);
        result.offsets.back().source = source;
      }
    }
  };
  // Approximate offsets first: then the steering gives the angle of the front wheels, which affects
  // their speeds.
  place_pairs({});
  const auto rough = best_speed(drive, result.offsets);
  if (rough && mapped(Source::steering)) {
    result.steering = steering_response(config.vehicle, drive.on_grid(log.of(Source::steering)),
                                        smooth(rough->value, 0.04), gyro, log.first_ns, report);
    if (result.steering->failure.empty())
      place_pairs(FrontWheels{result.steering->front_wheels, result.steering->side_speed});
  }
  for (const Source source :
       {Source::wheel_front_left, Source::wheel_front_right, Source::wheel_rear_left,
        Source::wheel_rear_right, Source::wheel_rear, Source::motor}) {
    if (!mapped(source)) continue;
    const bool paired = std::ranges::any_of(
        result.offsets, [source](const SourceOffset& done) { return done.source == source; });
    if (paired) continue;
    if (camera_placed) {
      begin(name_of(source) + " against the camera's way");
      result.offsets.push_back(speed_by_camera(drive, source, camera, camera_offset));
    } else {
      result.offsets.push_back({source, "the camera's way", 0.0, 0.0, 0.0,
                                "one wheel speed alone does not show turns; with --camera its "
                                "distance can be compared"});
    }
  }
  if (const auto speed = best_speed(drive, result.offsets)) {
    begin("accelerations");
    if (mapped(Source::accel_x)) result.offsets.push_back(longitudinal(drive, *speed));
    if (mapped(Source::accel_y)) result.offsets.push_back(lateral(drive, *speed));
  }
  return result;
}

}  // namespace odomd::tools
