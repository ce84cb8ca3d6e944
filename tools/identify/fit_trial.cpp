#include "tools/identify/fit_trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/log_reader.hpp"
#include "tools/drive_evaluation.hpp"
#include "tools/identify/config_patch.hpp"
#include "tools/identify/fit_drive.hpp"
#include "tools/identify/fit_reference.hpp"
#include "tools/text.hpp"
#include "tools/tune/score.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr std::array goals{Goal::prediction, Goal::second, Goal::position, Goal::heading};
constexpr double part_s = 8.0;         // of a 1:10 car
constexpr std::size_t most_parts = 8;  // of a drive
constexpr double as_good = 1.003;      // errors that are no worse
constexpr double half_as_good = 1.1;   // and those of every other part alone
constexpr double worth_it = 0.98;      // what more than a value must bring

struct Group {
  std::string_view name;
  std::vector<std::size_t> findings;
};

bool is_wheel(std::string_view key) {
  return key.find(".wheel_") != std::string_view::npos ||
         key.find(".motor.") != std::string_view::npos;
}

// Values that hang together go in together.
std::string_view group_of(std::string_view key) {
  if (key.starts_with("vehicle.cornering")) return "tyres";
  if (key == "vehicle.yaw_inertia") return "yaw inertia";
  if (key == "vehicle.track_width") return "track width";
  if (key.starts_with("imu.")) return "place of the IMU";
  if (key.starts_with("can.signals.steering")) return "steering";
  if (is_wheel(key)) return key.ends_with(".latency") ? "ages of the wheels" : "wheel scales";
  if (key.ends_with(".latency")) return "ages of gyro and accelerometers";
  if (key.starts_with("can.signals.yaw_rate")) return "gyro's scale and bias";
  if (key.starts_with("can.signals.accel")) return "accelerometers' biases";
  if (key == "camera.lever_arm[2]") return "yaw of the camera";
  if (key.starts_with("camera.")) return "place of the camera";
  return {};
}

std::vector<Group> groups_of(const Findings& findings) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < findings.values.size(); ++i) {
    const Finding& finding = findings.values[i];
    if (finding.key.empty() || finding.determined == Determined::no) continue;
    const std::string_view name = group_of(finding.key);
    if (name.empty()) continue;
    auto group = std::ranges::find(groups, name, &Group::name);
    if (group == groups.end()) group = groups.insert(groups.end(), {name, {}});
    group->findings.push_back(i);
  }
  return groups;
}

using Patch = std::vector<ConfigValue>;

Patch together(Patch one, const Patch& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

/// Errors over those of the configuration: of all parts, of the even ones, of the odd ones.
struct Ratio {
  double all = std::numeric_limits<double>::infinity();
  std::array<double, 2> half{all, all};
};

/// The way of the centre of gravity, whole and in parts.
std::vector<Trajectory> parts_of(const Trajectory& reference, const estimator::Pose2& arm,
                                 double slow) {
  const Trajectory whole = at_centre_of_gravity(reference, arm);
  const std::int64_t first = whole.points.front().t_ns, last = whole.points.back().t_ns;
  const auto count = static_cast<std::int64_t>(
      std::clamp(1e-9 * static_cast<double>(last - first) / (part_s * slow), 2.0,
                 static_cast<double>(most_parts)));
  std::vector<Trajectory> parts{whole};
  for (std::int64_t k = 0; k < count; ++k)
    parts.push_back(cut_to(whole, first + k * ((last - first) / count),
                           first + (k + 1) * ((last - first) / count)));
  return parts;
}

/// The drives, and what replays of them are compared with.
class Judge {
 public:
  explicit Judge(std::span<const tools::Drive> drives) : drives_(drives), before_(scores({})) {}

  [[nodiscard]] Ratio ratio(const Patch& patch) {
    std::vector<Score> tried;
    try {
      tried = scores(patch);
    } catch (const std::invalid_argument&) {
      return {};  // no configuration, or none that comes to a pose
    }
    Ratio result;
    result.all = relative_error(tried, before_, goals);
    for (const std::size_t half : {0U, 1U}) {
      std::vector<Score> now, then;
      for (std::size_t i = half; i < tried.size(); i += 2) {
        now.push_back(tried[i]);
        then.push_back(before_[i]);
      }
      result.half[half] = relative_error(now, then, goals);
    }
    return result;
  }

  [[nodiscard]] std::size_t replays() const { return replays_; }

 private:
  std::vector<Score> scores(const Patch& patch) {
    std::vector<Score> result;
    for (const tools::Drive& drive : drives_) {
      const daemon::Config& own = drive.config;
      daemon::Config config = daemon::parse_config(patched(own.text, own.file, patch), own.file);
      config.can.sources = own.can.sources;
      config.can.dbc = own.can.dbc;
      std::vector<std::string> told_already;
      static_cast<void>(daemon::load_databases(config, told_already));
      const ReplayedDrive replayed = replay_drive(drive, config);
      ++replays_;
      const auto [x, y, yaw] = config.camera.lever_arm;
      for (const Trajectory& part : parts_of(*drive.reference, {x, y, yaw}, slowness(own)))
        result.push_back(score_of(evaluate(part, replayed.poses, Align::first)));
    }
    return result;
  }

  std::span<const tools::Drive> drives_;
  std::size_t replays_ = 0;
  std::vector<Score> before_;
};

std::string in_words(double ratio) {
  if (!std::isfinite(ratio)) return "impossible";
  return fixed(100.0 * std::fabs(ratio - 1.0), 1) + (ratio > 1.0 ? " % worse" : " % better");
}

// A reading that is mostly vibration is worth E[a | y] = y σ_a² / (σ_a² + σ_v²): a share of it.
// Found on one half of the parts it has to help the other, both ways.
void find_shares(Judge& judge, const daemon::Config& config, Findings& findings, Patch& taken,
                 double& now) {
  constexpr std::array shares{0.7, 0.5, 0.35, 0.25, 0.17, 0.12, 0.08};
  constexpr double spread = 0.2;  // between two of them, relative
  for (const std::string role : {"accel_x", "accel_y"}) {
    const auto binding = std::ranges::find(config.can.bindings, role, &can::SignalBinding::role);
    if (binding == config.can.bindings.end()) continue;
    const std::string key = "can.signals." + role + ".scale";
    const auto with = [&](double share) {
      return together(taken, {{key, binding->scale * share, ""}});
    };
    const Ratio all_of_it = judge.ratio(taken);
    std::array<Ratio, shares.size()> ratios;
    for (std::size_t i = 0; i < shares.size(); ++i) ratios[i] = judge.ratio(with(shares[i]));
    const auto best_of = [&](auto error) { return std::ranges::min_element(ratios, {}, error); };
    bool holds = true;
    for (const std::size_t half : {0U, 1U}) {
      const auto* const here = best_of([&](const Ratio& r) { return r.half[half]; });
      holds = holds && here->half[1 - half] < worth_it * all_of_it.half[1 - half];
    }
    const auto* const best = best_of(&Ratio::all);
    if (!holds || best->all >= worth_it * now) continue;
    const double share = shares[static_cast<std::size_t>(best - ratios.begin())];
    findings.values.push_back({.name = "part of " + role + " to take",
                               .key = key,
                               .value = binding->scale * share,
                               .sigma = std::fabs(binding->scale) * share * spread,
                               .unit = "",
                               .remark = "by replay: errors " + in_words(best->all / now)});
    taken = with(share);
    now = best->all;
  }
}

}  // namespace

tools::Drive trial_drive(const std::string& name, const daemon::Config& config,
                         std::span<const std::string> logs,
                         std::vector<estimator::CameraPose> poses, double from, double to) {
  tools::Drive drive;
  drive.name = name;
  drive.folder = name;
  drive.config = config;
  drive.databases = daemon::load_databases(drive.config, drive.warnings);
  can::BusNames buses;
  for (const std::string& bus : daemon::expected_buses(drive.config)) buses.index_of(bus);
  can::MergedLog log(logs, buses);
  std::int64_t first = 0, last = std::numeric_limits<std::int64_t>::max();
  while (const can::Frame* frame = log.next()) {
    if (drive.frames.empty()) {
      first = frame->time_ns;
      if (to < 1e8) last = first + static_cast<std::int64_t>(1e9 * to);
    }
    if (frame->time_ns > last) break;
    drive.frames.push_back(*frame);
  }
  drive.buses = buses.all();
  // Poses of before and after have no replay to be held against.
  if (!drive.frames.empty()) last = std::min(last, drive.frames.back().time_ns);
  std::ranges::sort(poses, {}, &estimator::CameraPose::capture_ns);
  const std::int64_t begin = first + static_cast<std::int64_t>(1e9 * from);
  std::erase_if(poses, [&](const estimator::CameraPose& pose) {
    return pose.capture_ns < begin || pose.capture_ns > last;
  });
  drive.reference = smoothed(poses, 0.25 * slowness(config));
  if (drive.reference->points.size() < 100)
    throw std::invalid_argument(name + ": poses too few to replay the drive against");
  return drive;
}

void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const std::function<void(const std::string&)>& progress) {
  const daemon::Config& config = drives.front().config;
  Judge judge(drives);
  std::vector<Group> groups = groups_of(findings);
  const auto patch_of = [&](const Group& group) {
    Patch patch;
    for (const std::size_t i : group.findings)
      patch.push_back({findings.values[i].key, findings.values[i].value, ""});
    return patch;
  };
  const auto tell = [&](const std::string& what) {
    if (progress)
      progress("trial, " + std::to_string(judge.replays()) + " replays of about " +
               std::to_string(drives.size() * (20 + groups.size() * groups.size() / 2)) + ": " +
               what);
  };

  Patch taken;
  double now = 1.0;
  find_shares(judge, config, findings, taken, now);
  tell("accelerometers " + in_words(now));
  nlohmann::ordered_json told;
  std::vector<Group> left = groups;
  Ratio here = judge.ratio(taken);
  while (!left.empty()) {
    std::vector<Ratio> ratios;
    ratios.reserve(left.size());
    for (const Group& group : left) ratios.push_back(judge.ratio(together(taken, patch_of(group))));
    const auto fits = [&](const Ratio& r) {
      return r.all <= as_good * now && r.half[0] <= half_as_good * here.half[0] &&
             r.half[1] <= half_as_good * here.half[1];
    };
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < left.size(); ++i)
      if (fits(ratios[i]) && (!best || ratios[i].all < ratios[*best].all)) best = i;
    if (!best) {
      for (std::size_t i = 0; i < left.size(); ++i) {
        const double change = ratios[i].all / now;
        const std::string how =
            in_words(change) + (change <= as_good ? ", but much worse on a half of it" : "");
        told[std::string(left[i].name)] = {{"taken", false}, {"error", ratios[i].all / now}};
        for (const std::size_t k : left[i].findings) {
          Finding& finding = findings.values[k];
          finding.use = Use::leave;
          finding.remark += (finding.remark.empty() ? "" : "; ") +
                            std::string{"left as configured: "} + "replayed " + how;
        }
      }
      break;
    }
    tell(std::string(left[*best].name) + " " + in_words(ratios[*best].all / now));
    told[std::string(left[*best].name)] = {{"taken", true}, {"error", ratios[*best].all / now}};
    taken = together(taken, patch_of(left[*best]));
    now = ratios[*best].all;
    here = ratios[*best];
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(*best));
  }
  findings.details["trial"] = {{"error", now}, {"replays", judge.replays()}, {"groups", told}};
}

}  // namespace odomd::tools::fitting
