#include "tools/identify/fit/trial.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "daemon/core/config_keys.hpp"
#include "tools/cli/text.hpp"
#include "tools/evaluation/drive_evaluation.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr double part_s = 8.0;         // for a 1:10 car
constexpr std::size_t most_parts = 8;  // per drive

// Ratios of the errors after a change to those before it.
constexpr double as_good = 1.003;       // up to this ratio an error counts as unchanged
constexpr double better = 0.995;        // below this ratio an error is clearly smaller
constexpr double shown_worse = 1.0005;  // rounds to 0.1 %
constexpr double half_as_good = 1.1;    // maximum for each half of the parts

constexpr std::int64_t spacing_ns = 20'000'000;
constexpr double far_off = 3.0;      // distance from the cubic in standard deviations
constexpr std::size_t fewest = 6;    // poses per cubic
constexpr double both_sides = 0.25;  // maximum time to a pose on each side / `half`

// The cubic's value at u = 0 for x, y and yaw: least squares, then again with weights 1 / (1 + (r /
// 3σ)²) from the residuals r.
Eigen::Vector3d smoothed_pose(std::span<const PoseSample> places, double t, double half) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixX4d a(count, 4);
  Eigen::MatrixX3d b(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PoseSample& place = places[static_cast<std::size_t>(i)];
    const double u = (place.t - t) / half;
    a.row(i) << 1.0, u, u * u, u * u * u;
    b.row(i) << place.x, place.y, place.yaw;
  }
  const Eigen::MatrixX3d rest = b - a * a.householderQr().solve(b);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PoseSample& place = places[static_cast<std::size_t>(i)];
    const double off =
        std::hypot(rest(i, 0), rest(i, 1)) / std::hypot(place.sigma_x, place.sigma_y) +
        std::fabs(rest(i, 2)) / place.sigma_yaw;
    const double weight = 1.0 / std::hypot(1.0, off / far_off);
    a.row(i) *= weight;
    b.row(i) *= weight;
  }
  return a.householderQr().solve(b).row(0);
}

// The group of a value: correlated values are accepted together.
std::string_view group_of(std::string_view key) {
  if (key == "camera.lever_arm[2]") return "yaw of the camera";
  if (const daemon::ConfigKey* row = daemon::config_key(key)) return row->group;
  if (key.starts_with("can.signals.steering")) return "steering";
  if (key.starts_with("can.signals.wheel_") || key.starts_with("can.signals.motor."))
    return key.ends_with(".latency") ? "ages of the wheels" : "wheel scales";
  if (key.ends_with(".latency")) return "ages of gyro and accelerometers";
  if (key.starts_with("can.signals.yaw_rate")) return "gyro's scale and bias";
  if (key.starts_with("can.signals.accel")) return "accelerometers' biases";
  return {};
}

std::string in_words(double ratio) {
  if (!std::isfinite(ratio)) return "impossible";
  return fixed(100.0 * std::fabs(ratio - 1.0), 1) + (ratio > 1.0 ? " % worse" : " % better");
}

std::vector<Group> groups_of(const Findings& findings) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < findings.values.size(); ++i) {
    const Finding& finding = findings.values[i];
    if (finding.key.empty() || finding.determined == Determined::no) continue;
    const std::string_view name = group_of(finding.key);
    if (name.empty()) continue;
    auto group = std::ranges::find(groups, name, &Group::name);
    if (group == groups.end()) group = groups.insert(groups.end(), {.name = std::string(name)});
    group->patch.push_back({finding.key, finding.value, ""});
    group->findings.push_back(i);
  }
  return groups;
}

/// The errors with one group toggled: dropped if it is accepted, accepted if it is not.
Ratio evaluate_with_toggled(std::vector<Group> groups, std::size_t which,
                            const std::function<Ratio(const Patch&)>& judge) {
  groups[which].accepted = !groups[which].accepted;
  Patch all;
  for (const Group& group : groups)
    if (group.accepted) all.insert(all.end(), group.patch.begin(), group.patch.end());
  return judge(all);
}

/// Scores for the path of the centre of gravity, whole and in parts.
std::vector<Score> scores(std::span<const tools::Drive> drives, const Patch& patch) {
  std::vector<Score> result;
  for (const tools::Drive& drive : drives) {
    const daemon::Config config = config_with(drive.config, patch);
    const ReplayedDrive replayed = replay_drive(drive, config);
    const auto [x, y, yaw] = config.camera.lever_arm;
    const Trajectory whole = at_centre_of_gravity(*drive.reference, {x, y, yaw});
    const auto add_score = [&](const Trajectory& path) {
      result.push_back(score_of(evaluate(path, replayed.poses, Align::first)));
    };
    add_score(whole);
    const std::int64_t first = whole.points.front().t_ns;
    const std::int64_t span = whole.points.back().t_ns - first;
    const auto count = static_cast<std::int64_t>(
        std::clamp(1e-9 * static_cast<double>(span) / (part_s * slowness(drive.config)), 2.0,
                   static_cast<double>(most_parts)));
    for (std::int64_t k = 0; k < count; ++k)
      add_score(cut_to(whole, first + k * (span / count), first + (k + 1) * (span / count)));
  }
  return result;
}

Ratio ratio_of(const std::vector<Score>& tried, const std::vector<Score>& before) {
  Ratio result{.all = relative_error(tried, before)};
  for (const std::size_t half : {0U, 1U}) {
    std::vector<Score> now, then;
    for (std::size_t i = half; i < tried.size(); i += 2) {
      now.push_back(tried[i]);
      then.push_back(before[i]);
    }
    result.half[half] = relative_error(now, then);
  }
  return result;
}

}  // namespace

Trajectory smoothed(std::span<const estimator::CameraPose> poses, double half) {
  Trajectory result{.name = "smoothed poses"};
  if (poses.empty()) return result;
  const std::int64_t first = poses.front().capture_ns;
  const std::vector<PoseSample> places = in_order(poses, first);
  const auto last_ns = static_cast<std::int64_t>(1e9 * places.back().t);
  for (std::int64_t after = 0; after <= last_ns; after += spacing_ns) {
    const double t = 1e-9 * static_cast<double>(after);
    const auto begin = std::ranges::lower_bound(places, t - half, {}, &PoseSample::t);
    const auto end = std::ranges::upper_bound(places, t + half, {}, &PoseSample::t);
    const auto here = std::ranges::lower_bound(places, t, {}, &PoseSample::t);
    if (end - begin < static_cast<std::ptrdiff_t>(fewest) || here == end || here == begin) continue;
    if (here->t - t > both_sides * half || t - std::prev(here)->t > both_sides * half) continue;
    const Eigen::Vector3d now = smoothed_pose({begin, end}, t, half);
    result.points.push_back({.t_ns = first + after, .pose = {now(0), now(1), now(2)}});
  }
  return result;
}

tools::Drive trial_drive(tools::Drive drive, std::vector<estimator::CameraPose> poses,
                         const Part& part) {
  const std::int64_t first_ns = drive.frames.empty() ? 0 : drive.frames.front().time_ns;
  const auto after = [first_ns](double seconds) {
    return first_ns + static_cast<std::int64_t>(1e9 * seconds);
  };
  const std::int64_t end_ns = after(std::min(part.to, 1e8));
  const auto later = std::ranges::find_if(
      drive.frames, [end_ns](const can::Frame& frame) { return frame.time_ns > end_ns; });
  drive.frames.erase(later, drive.frames.end());
  std::ranges::sort(poses, {}, &estimator::CameraPose::capture_ns);
  // Poses before and after the log cannot be compared with a replay.
  std::erase_if(poses, [&](const estimator::CameraPose& pose) {
    return drive.frames.empty() || pose.capture_ns < after(part.from) ||
           pose.capture_ns > drive.frames.back().time_ns;
  });
  drive.cameras.clear();
  drive.reference = smoothed(poses, 0.25 * slowness(drive.config));
  if (drive.reference->points.size() < 100)
    refuse("{}: too few poses to evaluate a replay of the drive", drive.name);
  return drive;
}

Ratio choose(std::vector<Group>& groups, const std::function<Ratio(const Patch&)>& judge,
             const ReportProgress& progress) {
  Ratio now{.all = 1.0, .half = {1.0, 1.0}};
  const auto best_of = [&](bool to_drop) {
    std::optional<std::pair<std::size_t, Ratio>> best;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (groups[i].accepted != to_drop) continue;
      const Ratio then = evaluate_with_toggled(groups, i, judge);
      const bool fits = then.all < (to_drop ? better : as_good) * now.all &&
                        then.half[0] <= half_as_good * now.half[0] &&
                        then.half[1] <= half_as_good * now.half[1];
      if (fits && (!best || then.all < best->second.all)) best = {i, then};
    }
    return best;
  };
  // The errors decrease with each change, so the loop ends; the limit guards against rounding.
  for (std::size_t turn = 0; turn < 4 * groups.size(); ++turn) {
    auto next = best_of(false);
    if (!next) next = best_of(true);
    if (!next) break;
    Group& group = groups[next->first];
    group.accepted = !group.accepted;
    if (progress)
      progress((group.accepted ? "" : "without ") + group.name + " " +
               in_words(next->second.all / now.all));
    now = next->second;
  }
  return now;
}

void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const ReportProgress& progress) {
  std::size_t replays = drives.size();
  const std::vector<Score> before = scores(drives, {});
  const auto judge = [&](const Patch& patch) -> Ratio {
    try {
      replays += drives.size();
      return ratio_of(scores(drives, patch), before);
    } catch (const std::invalid_argument&) {
      return {};
    }
  };
  std::vector<Group> groups = groups_of(findings);
  const std::size_t usual = drives.size() * (1 + groups.size() * (groups.size() + 5) / 2);
  const Ratio now = choose(groups, judge, [&](const std::string& what) {
    if (progress)
      progress("trial, " + std::to_string(replays) + " replays of about " + std::to_string(usual) +
               ": " + what);
  });
  nlohmann::ordered_json tried;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Group& group = groups[i];
    const double then = evaluate_with_toggled(groups, i, judge).all;
    const double change = group.accepted ? now.all / then : then / now.all;
    tried[group.name] = {{"taken", group.accepted}, {"error", change}};
    const bool equal = change <= as_good;
    if (group.accepted && change < shown_worse) continue;
    const std::string remark =
        group.accepted ? "accepted: replayed " + in_words(change) + ", too little to matter"
                       : "left as configured: replayed " + in_words(change) +
                             (equal ? ", but much worse on half of it" : "");
    for (const std::size_t k : group.findings) {
      Finding& finding = findings.values[k];
      if (!group.accepted) finding.use = Use::leave;
      finding.remark += (finding.remark.empty() ? "" : "; ") + remark;
    }
  }
  findings.details["trial"] = {{"error", now.all}, {"replays", replays}, {"groups", tried}};
}

}  // namespace odomd::tools::fitting
