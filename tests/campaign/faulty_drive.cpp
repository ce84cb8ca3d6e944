#include "tests/campaign/faulty_drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "daemon/core/pipeline.hpp"
#include "tools/fault/injector.hpp"
#include "tools/fault/stream_faults.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::campaign {
namespace {

using estimator::CameraPose;

// A bus without frames: signals of this bus are left out.
constexpr const char* no_bus = "nowhere";

double mahalanobis(double dx, double dy, const odom_pose& pose) {
  const double xx = pose.covariance[0];
  const double xy = pose.covariance[1];
  const double yy = pose.covariance[3];
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 0.0)) return std::hypot(dx, dy) > 0.0 ? 1e9 : 0.0;
  return std::sqrt(std::max(0.0, (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant));
}

}  // namespace

Drive read_drive(const tools::DriveFiles& files) {
  Drive drive{tools::read_drive(files)};
  if (!drive.reference)
    throw std::invalid_argument(files.folder.string() + ": has no truth.csv to compare with");
  drive.buses.emplace_back(no_bus);
  const std::int64_t period_ns = drive.config.realtime.period_ns;
  drive.first_tick_ns = tools::first_tick_ns(drive.frames.front().time_ns, period_ns);
  const std::int64_t last_ns = drive.frames.back().time_ns;
  drive.ticks =
      static_cast<std::size_t>((last_ns - drive.first_tick_ns + period_ns - 1) / period_ns) + 1;
  return drive;
}

Sent sent(const Drive& drive, std::span<const fault::Fault> faults) {
  Sent sent;
  fault::Injector injector(drive.config, drive.databases, drive.buses, faults);
  for (const can::Frame& frame : drive.frames) injector.take(frame, sent.frames);
  injector.release(fault::end_of_time, sent.frames);
  fault::CameraInjector camera(faults, drive.start_ns());
  for (const CameraPose& pose : drive.cameras) camera.take(pose, sent.cameras);
  camera.release(fault::end_of_time, sent.cameras);
  return sent;
}

FaultyDrive::FaultyDrive(const Drive& drive, Camera camera, std::size_t begin)
    : drive_(drive), camera_(camera), begin_(begin) {
  for (std::size_t i = 0; i < drive.ticks; ++i)
    truth_.push_back(at(drive.reference.value(), drive.tick_ns(i)));
  const std::int64_t begin_ns = drive.tick_ns(begin);
  const std::span frames(drive.frames);
  const std::span cameras(drive.cameras);
  frames_before_ = static_cast<std::size_t>(
      std::ranges::find_if(frames, [&](const auto& one) { return one.time_ns > begin_ns; }) -
      frames.begin());
  cameras_before_ = static_cast<std::size_t>(
      std::ranges::find_if(cameras, [&](const auto& one) { return one.arrival_ns > begin_ns; }) -
      cameras.begin());

  const auto whole = pipeline(0);
  healthy_ =
      play(*whole, frames.first(frames_before_), cameras.first(cameras_before_), 0, begin + 1);
  state_ = std::make_unique<daemon::PipelineState>(whole->state());
  protections_.assign(whole->protections().begin(), whole->protections().end());
  const Run rest = play(*whole, frames.subspan(frames_before_), cameras.subspan(cameras_before_),
                        begin + 1, drive.ticks);
  healthy_.insert(healthy_.end(), rest.begin(), rest.end());
}

std::unique_ptr<daemon::Pipeline> FaultyDrive::pipeline(fault::Sources left_out) const {
  daemon::Config config = drive_.config;
  for (can::SignalBinding& binding : config.can.bindings)
    if (fault::contains(left_out, static_cast<estimator::Source>(binding.channel)))
      binding.bus = no_bus;
  return std::make_unique<daemon::Pipeline>(config, drive_.databases, drive_.buses,
                                            camera_ == Camera::on);
}

std::unique_ptr<daemon::Pipeline> FaultyDrive::resumed(fault::Sources left_out) const {
  auto result = pipeline(left_out);
  result->restore(*state_, protections_);
  return result;
}

Tick FaultyDrive::tick(daemon::Pipeline& pipeline, std::size_t number) const {
  const daemon::TickRecord& record = pipeline.tick(number, drive_.tick_ns(number));
  const odom_pose& pose = record.pose;
  Tick tick{.initialised = record.initialised,
            .mode = pose.mode,
            .conditions = pose.conditions,
            .health = pose.health};
  for (std::size_t i = 0; i < tick.flags.size(); ++i)
    tick.flags[i] = static_cast<std::uint8_t>(pipeline.statistics().sources[i].flag.get());
  const auto& truth = truth_[number];
  if (!truth || !record.initialised) return tick;
  const double dx = pose.x - truth->pose.x;
  const double dy = pose.y - truth->pose.y;
  tick.position_m = std::hypot(dx, dy);
  tick.yaw_rad = std::abs(std::remainder(pose.yaw - truth->pose.yaw, 2.0 * std::numbers::pi));
  const double sigma_yaw = std::sqrt(std::max(1e-18, pose.covariance[5]));
  tick.sigmas = std::max(mahalanobis(dx, dy, pose), tick.yaw_rad / sigma_yaw);
  return tick;
}

// Like tools::replay(), but up to the drive's last tick even if frames are missing.
Run FaultyDrive::play(daemon::Pipeline& pipeline, std::span<const can::Frame> frames,
                      std::span<const CameraPose> cameras, std::size_t from, std::size_t to) const {
  Run run;
  run.reserve(to - from);
  auto frame = frames.begin();
  auto camera = cameras.begin();
  for (std::size_t number = from; number < to; ++number) {
    const std::int64_t now_ns = drive_.tick_ns(number);
    for (; frame != frames.end() && frame->time_ns <= now_ns; ++frame)
      pipeline.take(*frame, now_ns);
    for (; camera_ == Camera::on && camera != cameras.end() && camera->arrival_ns <= now_ns;
         ++camera)
      pipeline.take(*camera);
    run.push_back(tick(pipeline, number));
  }
  return run;
}

Run FaultyDrive::with(std::span<const fault::Fault> faults) const {
  // Before the faults, what is sent equals the drive.
  const Sent failed = sent(drive_, faults);
  const auto pipeline = resumed(0);
  return play(*pipeline, std::span(failed.frames).subspan(frames_before_),
              std::span(failed.cameras).subspan(cameras_before_), begin_ + 1, drive_.ticks);
}

Run FaultyDrive::without(fault::Sources sources) const {
  const auto pipeline = resumed(sources);
  std::span<const CameraPose> cameras = std::span(drive_.cameras).subspan(cameras_before_);
  if (fault::contains(sources, estimator::Source::camera)) cameras = {};
  return play(*pipeline, std::span(drive_.frames).subspan(frames_before_), cameras, begin_ + 1,
              drive_.ticks);
}

}  // namespace odomd::campaign
