#include "tools/doctor/drive.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "tools/doctor/bus.hpp"
#include "tools/doctor/latencies.hpp"
#include "tools/evaluation/drive_checks.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostic;
using diagnostics::Diagnostics;
using diagnostics::kind;

// What the filter does not fit because of a cause is no finding of its own.
constexpr std::array consequences{&kind("model_fault"),        &kind("out_of_range"),
                                  &kind("contradicts_others"), &kind("inconsistent"),
                                  &kind("often_gated"),        &kind("clocks_differ"),
                                  &kind("other_drive")};

bool is_consequence(const Diagnostic& one) {
  return std::ranges::find(consequences, one.kind) != consequences.end();
}

bool is_cause(const Diagnostic& one) {
  constexpr std::array causes{&kind("mass_unlike_a_car"),
                              &kind("inertia_unlike_a_car"),
                              &kind("track_unlike_a_car"),
                              &kind("stiffness_unlike_a_tyre"),
                              &kind("wrong_sign"),
                              &kind("left_right_swapped"),
                              &kind("front_rear_swapped"),
                              &kind("axes_swapped"),
                              &kind("wrong_unit"),
                              &kind("camera_mirrored"),
                              &kind("camera_wrong_unit"),
                              &kind("runs_backwards"),
                              &kind("scale_off"),
                              &kind("positions_in_millimetres"),
                              &kind("positions_in_centimetres"),
                              &kind("yaw_in_degrees"),
                              &kind("camera_turns_unrelated"),
                              &kind("camera_outside_log"),
                              &kind("latency_off")};
  return std::ranges::find(causes, one.kind) != causes.end();
}

bool follows_from_mass(const Diagnostic& one) {
  return one.kind == &kind("inertia_unlike_a_car") || one.kind == &kind("track_unlike_a_car") ||
         one.kind == &kind("stiffness_unlike_a_tyre");
}

// Those of which nothing has been found yet.
void append_new(Diagnostics& to, const Diagnostics& others) {
  for (const Diagnostic& one : others)
    if (std::ranges::none_of(to, [&](const Diagnostic& other) {
          return other.kind == one.kind && other.subject == one.subject;
        }))
      to.push_back(one);
}

// Signs and scales that the replay does not compare, else times.
Diagnostics compare_sensors(const Drive& drive) try {
  const SignalLog log = signals_of(drive);
  if (const auto wrong = find_disagreement(drive.config, log, drive.cameras)) return {*wrong};
  return examine_latencies(drive.config,
                           estimate_latencies(drive.config, log, drive.cameras).offsets);
} catch (const std::invalid_argument&) {
  return {};  // without a gyro or too short
}

}  // namespace

Diagnostics examine_drive(const DriveFiles& files) {
  return examine_drive(read_drive(files));
}

Diagnostics examine_drive(const Drive& drive) {
  Diagnostics all = drive.config.warnings;
  append_new(all, drive.warnings);
  const Diagnostics traffic = examine_traffic(drive);
  append_new(all, traffic);
  try {
    append_new(all, check_drive(drive, drive.config));
  } catch (const NoPose& none) {
    if (traffic.empty()) append_new(all, none.warnings);
    return all;  // else no pose without the messages that have been named
  } catch (const std::invalid_argument&) {
    if (traffic.empty()) throw;
    return all;  // without a frame
  }
  if (std::ranges::none_of(all, is_cause)) {
    const Diagnostics compared = compare_sensors(drive);
    if (!compared.empty()) std::erase_if(all, is_consequence);
    append_new(all, compared);
  }
  if (std::ranges::any_of(all, is_cause)) std::erase_if(all, is_consequence);
  const auto is_mass = [](const Diagnostic& one) { return one.kind == &kind("mass_unlike_a_car"); };
  if (std::ranges::any_of(all, is_mass)) std::erase_if(all, follows_from_mass);
  return all;
}

}  // namespace odomd::tools::doctor
