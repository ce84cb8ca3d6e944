#include "tools/identify/fit/trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/identify/fit/choice.hpp"
#include "tools/identify/fit/judge.hpp"

namespace odomd::tools::fitting {
namespace {

bool is_wheel(std::string_view key) {
  return key.find(".wheel_") != std::string_view::npos ||
         key.find(".motor.") != std::string_view::npos;
}

// Correlated values go in together.
std::string_view group_of(std::string_view key) {
  // Rear ones determine the side slip, front ones the response to steering, which the gyro measures
  // better.
  if (key.starts_with("vehicle.cornering") || key.starts_with("vehicle.grip"))
    return key.ends_with("front") ? "front tyres" : "rear tyres";
  if (key == "vehicle.yaw_inertia") return "yaw inertia";
  if (key == "vehicle.track_width") return "track width";
  if (key.starts_with("imu.")) return "place of the IMU";
  if (key.starts_with("can.signals.steering")) return "steering";
  if (key.starts_with("steering.")) return "steering actuator";
  if (is_wheel(key)) return key.ends_with(".latency") ? "ages of the wheels" : "wheel scales";
  if (key.ends_with(".latency")) return "ages of gyro and accelerometers";
  if (key.starts_with("can.signals.yaw_rate")) return "gyro's scale and bias";
  if (key.starts_with("can.signals.accel")) return "accelerometers' biases";
  if (key == "camera.lever_arm[2]") return "yaw of the camera";
  if (key.starts_with("camera.")) return "place of the camera";
  return {};
}

std::string in_words(double ratio) {
  if (!std::isfinite(ratio)) return "impossible";
  return fixed(100.0 * std::fabs(ratio - 1.0), 1) + (ratio > 1.0 ? " % worse" : " % better");
}

std::vector<Candidate> candidates_of(const Findings& findings) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < findings.values.size(); ++i) {
    const Finding& finding = findings.values[i];
    if (finding.key.empty() || finding.determined == Determined::no) continue;
    const std::string_view name = group_of(finding.key);
    if (name.empty()) continue;
    auto one = std::ranges::find(candidates, name, &Candidate::name);
    if (one == candidates.end())
      one = candidates.insert(candidates.end(), {.name = std::string(name)});
    one->patch.push_back({finding.key, finding.value, ""});
    one->findings.push_back(i);
  }
  return candidates;
}

// The best estimate from a reading with vibration is E[a | y] = y σ_a² / (σ_a² + σ_v²), a share of
// it. A share found on one half of the parts must help on the other, both ways.
void find_shares(Judge& judge, const daemon::Config& config, Choice& choice) {
  constexpr std::array shares{0.7, 0.5, 0.35, 0.25, 0.17, 0.12, 0.08};
  constexpr double spread = 0.2;  // between two of them, relative
  for (const std::string role : {"accel_x", "accel_y"}) {
    const auto binding = std::ranges::find(config.can.bindings, role, &can::SignalBinding::role);
    const std::string name = "part of " + role;
    if (binding == config.can.bindings.end() ||
        std::ranges::count(choice.candidates(), name, &Candidate::name) > 0)
      continue;
    const std::string key = "can.signals." + role + ".scale";
    const auto scaled = [&](double share) { return Patch{{key, binding->scale * share, ""}}; };
    std::array<Ratio, shares.size()> ratios;
    for (std::size_t i = 0; i < shares.size(); ++i)
      ratios[i] = judge.ratio(together(choice.patch(), scaled(shares[i])));
    const auto best_of = [&](auto error) { return std::ranges::min_element(ratios, {}, error); };
    const Ratio all_of_it = choice.now();
    bool holds = true;
    for (const std::size_t half : {0U, 1U}) {
      const auto* const here = best_of([&](const Ratio& r) { return r.half[half]; });
      holds = holds && here->half[1 - half] < worth_it * all_of_it.half[1 - half];
    }
    const auto* const best = best_of(&Ratio::all);
    if (!holds || best->all >= worth_it * all_of_it.all) continue;
    const double share = shares[static_cast<std::size_t>(best - ratios.begin())];
    choice.take({.name = name,
                 .patch = scaled(share),
                 .own = Finding{.name = name + " to take",
                                .key = key,
                                .value = binding->scale * share,
                                .sigma = std::fabs(binding->scale) * share * spread}},
                *best);
  }
}

/// Marks the values that are not taken, with their effect on a replay: they stay as configured.
void report(Choice& choice, Findings& findings, nlohmann::ordered_json& groups) {
  for (std::size_t i = 0; i < choice.candidates().size(); ++i) {
    const Candidate& one = choice.candidates()[i];
    const Ratio turned = choice.turned(i);
    const double change = one.taken ? choice.now().all / turned.all : turned.all / choice.now().all;
    groups[one.name] = {{"taken", one.taken}, {"error", change}};
    if (one.taken && one.own) {
      findings.values.push_back(*one.own);
      findings.values.back().remark = "by replay: errors " + in_words(change);
    }
    if (one.taken) continue;
    const std::string how =
        in_words(change) + (change <= as_good ? ", but much worse on half of it" : "");
    for (const std::size_t k : one.findings) {
      Finding& finding = findings.values[k];
      finding.use = Use::leave;
      finding.remark += (finding.remark.empty() ? "" : "; ") + std::string{"left as configured: "} +
                        "replayed " + how;
    }
  }
}

}  // namespace

void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const std::function<void(const std::string&)>& progress) {
  Judge judge(drives);
  Choice choice([&judge](const Patch& patch) { return judge.ratio(patch); },
                candidates_of(findings));
  const std::size_t groups = choice.candidates().size();
  const auto say = [&](const std::string& what) {
    if (progress)
      progress("trial, " + std::to_string(judge.replays()) + " replays of about " +
               std::to_string(drives.size() * (40 + groups * (groups + 5) / 2)) + ": " + what);
  };
  const auto shares = [&] {
    const double before = choice.now().all;
    find_shares(judge, drives.front().config, choice);
    say("accelerometers " + in_words(choice.now().all / before));
  };
  const auto turns = [&] {
    // The errors decrease with each change, so the loop ends; the limit guards against rounding.
    for (std::size_t turn = 0; turn < 4 * groups; ++turn) {
      const double before = choice.now().all;
      const std::optional<std::string> turned = choice.turn_best();
      if (!turned) break;
      say(*turned + " " + in_words(choice.now().all / before));
    }
  };
  // First with the sensors as configured, then, if that was not used, as found.
  shares();
  turns();
  shares();
  turns();
  nlohmann::ordered_json tried;
  report(choice, findings, tried);
  findings.details["trial"] = {
      {"error", choice.now().all}, {"replays", judge.replays()}, {"groups", tried}};
}

}  // namespace odomd::tools::fitting
