#include "tools/identify/latency/latency_estimate.hpp"

#include <algorithm>
#include <cmath>

#include "tools/cli/text.hpp"
#include "tools/identify/common/agreement.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

// ψ_camera(t) = (1 + s) ∫ gyro(t - D) + b t + c
SourceOffset camera_yaw(const GyroDrive& drive, std::span<const estimator::CameraPose> camera) {
  OffsetRegression r;
  for (const PoseSample& pose : in_order(camera, drive.log.first_ns)) {
    if (pose.t < drive.begin + r.range || pose.t > drive.end - r.range) continue;
    r.t.push_back(pose.t);
    r.y.push_back(pose.yaw);
  }
  const auto since = [&](double begin) {
    return on_grid_of(drive.turned, [=](double t) { return std::max(0.0, t - begin); });
  };
  // The gyro's bias and its random walk: a line with bends at least 15 s apart.
  r.basis = {{drive.turned, 1.0, 0.1}, {constant(drive.turned)}, {since(drive.begin)}};
  const double span = drive.end - drive.begin;
  const int knots = static_cast<int>(std::clamp(std::floor(span / 15.0) - 1.0, 0.0, 40.0));
  for (int k = 1; k <= knots; ++k)
    r.basis.push_back({since(drive.begin + span * k / (knots + 1)), 0.0, 5e-3});
  SourceOffset result = as_offset(Source::camera, "the gyro's turn", solve(r));
  // For angles the explained share means little: also require enough turns.
  if (result.failure.empty() && std::ranges::none_of(drive.yaw_rate.value, [](double yaw_rate) {
        return std::fabs(yaw_rate) >= 0.02;
      }))
    result.failure = "the car does not turn";
  return result;
}

}  // namespace

LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                   std::span<const estimator::CameraPose> camera,
                                   const ReportProgress& report) {
  const auto begin = [&report](const std::string& what) {
    if (report) report(what);
  };
  const Series& gyro = log.need(Source::yaw_rate);  // the reference of all offsets
  GyroDrive drive{config, log, 0.0, 0.0, {}, {}};
  drive.begin = drive.log.seconds(gyro.t_ns.front());
  drive.end = drive.log.seconds(gyro.t_ns.back());
  if (drive.end - drive.begin < 10.0) {
    refuse(
        "the log contains {} s of gyro; at least ten are needed, ten minutes with curves and stops "
        "are good",
        fixed(drive.end - drive.begin, 1));
  }
  // Unrelated poses are found and reported later.
  check_agreement(config, log, camera, {.unrelated = UnrelatedPoses::accept});
  drive.yaw_rate = drive.on_grid(gyro);
  drive.turned = integral(drive.yaw_rate);

  LatencyEstimate result;
  double camera_offset = 0.0;
  bool camera_placed = false;
  if (!camera.empty()) {
    begin("yaw_rate against the camera");
    result.offsets.push_back(camera_yaw(drive, camera));
    camera_placed = result.offsets.back().failure.empty();
    camera_offset = result.offsets.back().offset;
  }
  const auto pair_offsets = [&](const std::optional<FrontWheels>& front_wheels) {
    std::vector<SourceOffset> offsets;
    for (const auto& [left, right] : estimator::wheel_pairs) {
      if (!log.has(left) || !log.has(right)) continue;
      begin(name_of(left) + " and " + name_of(right) + " against yaw_rate");
      offsets.insert(offsets.end(), 2, wheel_pair(drive, left, right, front_wheels));
      offsets.back().source = right;
    }
    return offsets;
  };
  // Approximate offsets first: with them the steering gives the angle of the front wheels, which
  // affects their speeds.
  std::vector<SourceOffset> pairs = pair_offsets({});
  const auto rough = best_speed(drive, pairs);
  if (rough && log.has(Source::steering)) {
    result.steering = steering_response(config.vehicle, drive.on_grid(log.of(Source::steering)),
                                        smooth(*rough, 0.04), gyro, log.first_ns, report);
    if (result.steering->failure.empty()) pairs = pair_offsets(result.steering->front_wheels);
  }
  result.offsets.insert(result.offsets.end(), pairs.begin(), pairs.end());
  for (const Source source : wheel_sources) {
    if (!log.has(source)) continue;
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
  return result;
}

}  // namespace odomd::tools
