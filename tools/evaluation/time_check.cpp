#include "tools/evaluation/time_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "tools/evaluation/camera_reference.hpp"
#include "tools/evaluation/drive_evaluation.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostic;
constexpr double same_clock = 0.015;  // s

std::optional<Diagnostic> report(const std::string& whose, const std::string& seen) {
  return found(diagnostics::kind("clocks_differ"), whose, seen);
}

// Keeps the offset that explains the most: a poor model has time errors of its own.
void keep_the_better(std::optional<TimeOffset>& best, const std::optional<TimeOffset>& other) {
  if (other && (!best || other->after < best->after)) best = other;
}

std::string look(double late_s) {
  return fmt::format("look {:.0f} ms {}", std::fabs(1e3 * late_s), late_s > 0.0 ? "late" : "early");
}

std::string by_how_much(const TimeOffset& offset, const char* error) {
  return fmt::format(" (the {} would be {:.3f} m, not {:.3f} m)", error, offset.after,
                     offset.before);
}

}  // namespace

std::optional<Diagnostic> check_times(const Trajectory& reference,
                                      std::span<const Trajectory> estimates, Align align) {
  std::optional<TimeOffset> found;
  for (const Trajectory& estimate : estimates)
    keep_the_better(found, offset_by_positions(reference, estimate, align));
  const char* error = "position rms";
  if (!found) {
    for (const Trajectory& estimate : estimates)
      keep_the_better(found, offset_by_motion(reference, estimate));
    error = "error over a second";
  }
  if (!found) return std::nullopt;
  return report(reference.name, "its times " + look(found->late_s) + " compared with the poses" +
                                    by_how_much(*found, error));
}

std::optional<Diagnostic> check_times(const Trajectory& reference, const Drive& drive,
                                      Align align) {
  const std::optional<Trajectory> odometry = motion(drive);
  if (!odometry) return std::nullopt;
  const std::optional<TimeOffset> of_reference = offset_by_motion(reference, *odometry);
  if (drive.cameras.empty() || reference.is_camera) {
    if (!of_reference) return std::nullopt;
    return report(reference.name, "its times " + look(of_reference->late_s) + " against the bus" +
                                      by_how_much(*of_reference, "error over a second"));
  }
  const auto& arm = drive.config.camera.lever_arm;
  const Trajectory camera = camera_trajectory(drive.cameras, {arm[0], arm[1], arm[2]});
  const std::optional<TimeOffset> of_camera = offset_by_motion(camera, *odometry);
  const std::optional<TimeOffset> between =
      offset_by_positions(reference, camera, align == Align::none ? Align::none : Align::fit);
  if (!between) {
    if (!of_reference || !of_camera ||
        std::fabs(of_reference->late_s - of_camera->late_s) > same_clock)
      return std::nullopt;
    return report(reference.name + ", camera.csv",
                  "their times " + look(of_reference->late_s) + " against the bus");
  }
  const std::string difference = by_how_much(*between, "rms between the two");
  // The bus shows which of the two is off; the two together show more precisely by how much.
  if (of_camera && !of_reference)
    return report("camera.csv",
                  "its times " + look(-between->late_s) + " against the bus" + difference);
  if (of_reference && !of_camera)
    return report(reference.name,
                  "its times " + look(between->late_s) + " against the bus" + difference);
  return report(
      reference.name + " and camera.csv",
      fmt::format("their times look {:.0f} ms apart, {} later{}", std::fabs(1e3 * between->late_s),
                  between->late_s > 0.0 ? "the reference's" : "the camera's", difference));
}

}  // namespace odomd::tools
