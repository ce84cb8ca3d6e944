#include "tools/replay/virtual_drive.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "daemon/core/pipeline.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/math/median.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {

void ReplaySummary::add_tick(const daemon::Pipeline& pipeline, const daemon::TickRecord& record,
                             std::int64_t time_ns) {
  const odom_pose& pose = record.pose;
  ++ticks;
  last_tick_ns = time_ns;
  last_mode = pose.mode;
  for (std::size_t source = 0; source < flagged.size(); ++source) {
    const daemon::SourceStatistics& statistics = pipeline.statistics().sources[source];
    ++flagged[source].at(statistics.flag.get());
    ++wired[source].at(statistics.wiring.get());
    inconsistent[source] += statistics.inconsistent.get();
  }
  const bool moves = pose.mode != ODOM_INITIALISING && pose.mode != ODOM_STANDSTILL;
  if ((pose.conditions & ODOM_COND_BIAS_UNLEARNT) != 0 && moves) ++bias_unlearnt;
  if ((pose.conditions & ODOM_COND_SCALE_IMPLAUSIBLE) != 0) ++scale_implausible;
  if (pose.mode == ODOM_FAULT && faulty++ == 0) {
    fault_ns = time_ns;
    fault_conditions = pose.conditions;
  }
  if (!record.initialised) return;
  ++poses;
  constexpr std::int64_t spacing_ns = 100'000'000;
  auto& points = odometry.points;
  if (points.empty() || pose.time_ns - points.back().t_ns >= spacing_ns)
    points.push_back(point_of(pose, Frame::odom));
}

void ReplaySummary::finish(const daemon::Pipeline& pipeline,
                           std::span<const estimator::CameraPose> camera_poses) {
  for (std::size_t source = 0; source < innovations.size(); ++source) {
    const daemon::SourceStatistics& statistics = pipeline.statistics().sources[source];
    innovations[source] = statistics.innovations.get();
    noise[source] = statistics.noise.get();
    for (std::size_t verdict = 0; verdict < verdicts[source].size(); ++verdict)
      verdicts[source][verdict] = statistics.verdicts[verdict].get();
  }
  std::vector<std::int64_t> delays_ns;
  for (const estimator::CameraPose& pose : camera_poses)
    delays_ns.push_back(pose.arrival_ns - pose.capture_ns);
  if (!delays_ns.empty()) camera_delay_s = static_cast<double>(median_of(delays_ns)) * 1e-9;
  camera_units = check_units("camera", camera_poses, {.trajectory = odometry});
}

ReplaySummary replay(daemon::Pipeline& pipeline, std::int64_t period_ns,
                     const NextFrame& next_frame, std::span<const estimator::CameraPose> cameras,
                     const PoseSink& sink, const JudgementSink& judged) {
  const can::Frame* frame = next_frame();
  ReplaySummary summary;
  if (frame != nullptr) summary.first_tick_ns = first_tick_ns(frame->time_ns, period_ns);
  auto camera = cameras.begin();

  std::int64_t tick_ns = summary.first_tick_ns;
  for (std::uint64_t tick = 0; frame != nullptr; ++tick, tick_ns += period_ns) {
    if (frame->time_ns - tick_ns > longest_pause_ns)
      throw PauseError("the log pauses for more than an hour after " +
                       std::to_string((tick_ns - summary.first_tick_ns) / 1'000'000'000) +
                       " s: cut it there and replay the parts, or correct the stamp");

    for (; frame != nullptr && frame->time_ns <= tick_ns; frame = next_frame()) {
      pipeline.take(*frame, tick_ns);
      ++summary.frames;
      if (tick_ns - frame->time_ns >= late_ns) ++summary.late;
    }
    for (; camera != cameras.end() && camera->arrival_ns <= tick_ns; ++camera) {
      if (camera->arrival_ns < summary.first_tick_ns) ++summary.cameras_before;
      pipeline.take(*camera);
      ++summary.cameras;
    }

    const daemon::TickRecord& record = pipeline.tick(tick, tick_ns);
    if (judged) judged(pipeline.judgements());
    summary.add_tick(pipeline, record, tick_ns);
    if (record.initialised) sink(record);
  }
  summary.cameras_after = static_cast<std::uint64_t>(cameras.end() - camera);
  summary.finish(pipeline, cameras);
  return summary;
}

}  // namespace odomd::tools
