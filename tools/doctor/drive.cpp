#include "tools/doctor/doctor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tools/diagnostics/kinds.hpp"
#include "tools/evaluation/evaluation_checks.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostic;
using diagnostics::Diagnostics;
using diagnostics::found;
using estimator::Source;

consteval auto kinds(auto... names) {
  return std::array{&kind(names)...};
}
// If a drive has one of the causes, the consequences are not reported.
constexpr auto causes =
    kinds("mass_unlike_a_car", "inertia_unlike_a_car", "track_unlike_a_car",
          "stiffness_unlike_a_tyre", "wrong_sign", "left_right_swapped", "front_rear_swapped",
          "axes_swapped", "wrong_unit", "camera_mirrored", "camera_wrong_unit", "runs_backwards",
          "scale_off", "positions_in_millimetres", "positions_in_centimetres", "yaw_in_degrees",
          "camera_turns_unrelated", "camera_outside_log", "source_unused", "latency_off");
constexpr auto consequences =
    kinds("bias_unlearnt", "model_fault", "out_of_range", "scale_implausible", "contradicts_others",
          "inconsistent", "often_gated", "clocks_differ", "other_drive", "frozen");
constexpr auto wrong_mass = kinds("mass_unlike_a_car");
constexpr auto consequences_of_mass =
    kinds("inertia_unlike_a_car", "track_unlike_a_car", "stiffness_unlike_a_tyre");

auto is_among(const auto& kinds) {
  return
      [&kinds](const Diagnostic& one) { return std::ranges::find(kinds, one.kind) != kinds.end(); };
}

// Appends the diagnostics that are not in `to` yet: those with another kind or subject or, if they
// have no subject, with another finding.
void append_new(Diagnostics& to, const Diagnostics& others) {
  for (const Diagnostic& one : others)
    if (std::ranges::none_of(to, [&](const Diagnostic& other) {
          return other.kind == one.kind &&
                 (one.subject.empty() ? other.seen == one.seen : other.subject == one.subject);
        }))
      to.push_back(one);
}

std::optional<Diagnostic> check_scatter(const Drive& drive, const SignalLog& log) {
  constexpr std::size_t enough = 40;  // poses
  const std::vector<PoseSample> poses = in_order(drive.cameras, log.first_ns);
  if (poses.size() < enough) return std::nullopt;
  const auto all = [&](double PoseSample::*member) {
    std::vector<double> values;
    for (const PoseSample& pose : poses) values.push_back(pose.*member);
    return values;
  };
  const double scatter =
      std::max(white_sigma(all(&PoseSample::x)), white_sigma(all(&PoseSample::y)));
  const double scatter_yaw = white_sigma(all(&PoseSample::yaw));
  const double sigma =
      std::max(median_of(all(&PoseSample::sigma_x)), median_of(all(&PoseSample::sigma_y)));
  const double sigma_yaw = median_of(all(&PoseSample::sigma_yaw));
  constexpr double far = 4.0;
  if (scatter < far * sigma && scatter_yaw < far * sigma_yaw) return std::nullopt;
  return found(kind("sigma_off"), "camera",
               fmt::format("its poses scatter by {:.2g} m and {:.2g} deg, their sigmas are {:.2g} "
                           "m and {:.2g} deg",
                           scatter, degrees * scatter_yaw, sigma, degrees * sigma_yaw),
               fmt::format("the sigmas of its poses by {:.2g} (x, y) and {:.2g} (yaw)",
                           std::max(scatter / sigma, 1.0), std::max(scatter_yaw / sigma_yaw, 1.0)));
}

/// Reports a signal that repeatedly stays at its largest magnitude.
std::optional<Diagnostic> check_range(const SignalLog& log, Source source) {
  constexpr std::size_t run = 5, runs_needed = 2;
  constexpr double step = 1e-9;
  const Series& series = log.of(source);
  if (series.size() < run * run) return std::nullopt;
  double end = 0.0;
  for (const double value : series.value) end = std::max(end, std::fabs(value));
  std::size_t runs = 0, samples = 0;
  for (std::size_t i = 0, from = 0; i <= series.size(); ++i) {
    if (i < series.size() && std::fabs(series.value[i]) >= end - step) continue;
    if (i - from >= run) ++runs, samples += i - from;
    from = i + 1;
  }
  // A coarse signal also repeats its other values.
  std::size_t others = 0, same = 1;
  for (std::size_t i = 1; i < series.size(); ++i) {
    same = series.value[i] == series.value[i - 1] ? same + 1 : 1;
    if (same == run && std::fabs(series.value[i]) < end - step) ++others;
  }
  if (runs < runs_needed || others >= runs) return std::nullopt;
  return found(kind("frozen"), name_of(source),
               fmt::format("stays at {:.3g}, the end of its range, in {} of its {} samples", end,
                           samples, series.size()));
}

// Finds faults that the replay would blame on another sensor: camera sigmas that do not match the
// scatter of its poses, and sensors at the end of their range.
Diagnostics find_hidden_faults(const Drive& drive, const SignalLog& log) {
  Diagnostics all;
  if (auto scatter = check_scatter(drive, log)) all.push_back(std::move(*scatter));
  for (const Source source : {Source::yaw_rate, Source::accel_x, Source::accel_y})
    if (auto clipped = check_range(log, source)) all.push_back(std::move(*clipped));
  return all;
}

/// The delay of the steering's stamps: the response time in [steering] minus the measured one. It
/// is a lower bound, since the actuator may be slower.
SourceOffset offset_of(const SteeringResponse& response,
                       const estimator::SteeringActuator& configured) {
  return {Source::steering,
          "the gyro's turn",
          configured.delay_s + configured.lag_s - response.in_all.value,
          response.in_all.sigma,
          response.explained,
          response.failure};
}

// Looks first for faults that hide others, then for wrong signs and scales that the replay does not
// find, and last for latencies. If a late sensor is found, it replaces the finding that the
// camera's poses and the gyro's turns differ in time.
DriveExamination compare_sensors(const Drive& drive) try {
  const SignalLog log = signals_of(drive);
  DriveExamination compared{find_hidden_faults(drive, log), {}};
  if (!compared.diagnostics.empty()) return compared;
  const auto wrong = find_disagreement(drive.config, log, drive.cameras);
  const bool is_other_scale = wrong && wrong->kind == &kind("scale_off");
  if (wrong && !is_other_scale && wrong->kind != &kind("clocks_differ") &&
      wrong->kind != &kind("camera_turns_unrelated"))
    return {{*wrong}, {}};
  if (const auto scale = find_wrong_scale(drive, log)) return {{*scale}, {}};
  if (is_other_scale) return {{*wrong}, {}};
  const LatencyEstimate estimate = estimate_latencies(drive.config, log, drive.cameras);
  std::vector<SourceOffset> offsets = estimate.offsets;
  if (const auto& steering = estimate.steering)
    offsets.push_back(offset_of(*steering, drive.config.vehicle.steering));
  compared = {examine_latencies(drive.config, offsets), latencies_unjudged(offsets)};
  if (compared.diagnostics.empty() && wrong) return {{*wrong}, {}};
  return compared;
} catch (const std::invalid_argument& error) {  // without a gyro or too short
  return {{}, fmt::format("signs, scales and latencies were not compared: {}", error.what())};
}

}  // namespace

std::string guesses_in(const std::filesystem::path& config) {
  std::ifstream file(config);
  std::size_t guesses = 0;
  for (std::string line; std::getline(file, line);)
    guesses += line.find("UNSURE:") == std::string::npos ? 0U : 1U;
  if (guesses == 0) return {};
  return fmt::format("{} of {} {} marked UNSURE",
                     guesses == 1 ? "1 line" : fmt::format("{} lines", guesses),
                     config.filename().string(), guesses == 1 ? "is" : "are");
}

DriveExamination examine_drive(const Drive& drive) {
  DriveExamination examination{drive.config.warnings, guesses_in(drive.config.file)};
  Diagnostics& all = examination.diagnostics;
  append_new(all, drive.warnings);
  const Diagnostics traffic = examine_traffic(drive);
  append_new(all, traffic);
  try {
    append_new(all, check_drive(drive));
  } catch (const NoPose& none) {
    if (traffic.empty()) append_new(all, none.warnings);
    return examination;  // otherwise the findings on the traffic explain the missing pose
  } catch (const std::invalid_argument&) {
    if (traffic.empty()) throw;
    return examination;  // no frame to replay
  }
  if (std::ranges::none_of(all, is_among(causes))) {
    const auto [compared, note] = compare_sensors(drive);
    if (!compared.empty()) std::erase_if(all, is_among(consequences));
    append_new(all, compared);
    if (!note.empty()) examination.note += (examination.note.empty() ? "" : "; ") + note;
  }
  if (std::ranges::any_of(all, is_among(causes))) std::erase_if(all, is_among(consequences));
  if (std::ranges::any_of(all, is_among(wrong_mass)))
    std::erase_if(all, is_among(consequences_of_mass));
  return examination;
}

}  // namespace odomd::tools::doctor
