#include "tools/drive_files/recording_folder.hpp"

#include <fcntl.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "can_protocol/sources/candump.hpp"
#include "daemon/core/recording_wire.hpp"
#include "estimator/integrity/admission.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::tools {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(),
                                       errno == ENOSPC
                                           ? "the disk is full; what was recorded until now is kept"
                                           : std::generic_category().message(errno)));
}

/// Creates the folder.
std::filesystem::path made(std::filesystem::path folder) {
  std::error_code error;
  if (!std::filesystem::create_directory(folder, error)) {
    throw std::invalid_argument(folder.string() + ": " +
                                (error ? "cannot be created: " + error.message()
                                       : "exists already; name another folder with --out"));
  }
  return folder;
}

void write_whole(const std::filesystem::path& path, const std::string& text) {
  GrowingFile file{path};
  file.text() = text;
  file.write();
  file.sync();
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

}  // namespace

GrowingFile::GrowingFile(std::filesystem::path path)
    : path_(std::move(path)),
      file_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666)) {
  if (!file_) fail(path_);
}

void GrowingFile::write() {
  for (std::size_t at = 0; at < text_.size();) {
    const ssize_t written = ::write(file_.get(), text_.data() + at, text_.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_);
    at += static_cast<std::size_t>(written);
    bytes_ += static_cast<std::uint64_t>(written);
  }
  text_.clear();
}

void GrowingFile::sync() {
  // Not every file system supports it (EINVAL).
  if (::fdatasync(file_.get()) != 0 && errno != EINVAL && errno != EROFS) fail(path_);
}

RecordingFolder::RecordingFolder(std::filesystem::path folder, RecordingStart start)
    : folder_(made(std::move(folder))),
      start_(std::move(start)),
      frames_(folder_ / recorded_frames),
      cameras_(folder_ / recorded_cameras),
      beat_(folder_ / recorded_beat),
      poses_(folder_ / recorded_poses) {
  for (const auto& file : start_.files) write_whole(folder_ / file.name, file.text);
  write_whole(folder_ / recorded_state, start_.state);
  cameras_.text() = header_of<estimator::CameraPose>(camera_columns);
  beat_.text() = header_of<BeatRow>(beat_columns);
  poses_.text() = record_header();
}

void RecordingFolder::begin(const daemon::TickMark& mark) {
  // The recording's clock shows the date and does not step. Its ticks are at multiples of the
  // period, as in a replay of can.log alone.
  const auto period = start_.hello.at("period_ns").get<std::int64_t>();
  const std::int64_t offset = std::max<std::int64_t>(mark.realtime_offset_ns, 0);
  clock_offset_ns_ = offset - offset % period;
  started_ = utc_now();
  const odom_pose& pose = mark.record.pose;
  if (mark.record.initialised) initial_ = {pose.x, pose.y, pose.yaw};
  counts_.first_tick = counts_.last_tick = pose.tick;
  write_info("");
}

void RecordingFolder::set_buses(std::vector<std::string> names) {
  start_.buses = std::move(names);
  if (counts_.first_tick != 0) write_info("");
}

void RecordingFolder::take(const daemon::TickMark& mark, std::span<const can::Frame> frames,
                           std::span<const estimator::CameraPose> cameras) {
  const bool first = counts_.first_tick == 0;
  if (first) begin(mark);
  for (can::Frame frame : frames) {
    // A frame without a stamp gets the time when it was read, in the pipeline and in a replay.
    frame.time_ns = frame.time_ns > 0 ? frame.time_ns + clock_offset_ns_ : 0;
    can::append_candump_line(frames_.text(), frame, start_.buses.at(frame.bus),
                             can::StampDecimals::nine);
  }
  counts_.frames += frames.size();

  std::string& rows = cameras_.text();
  for (estimator::CameraPose camera : cameras) {
    if (!estimator::is_usable(camera)) {
      ++counts_.unusable_cameras;
      continue;
    }
    ++counts_.cameras;
    camera.arrival_ns += clock_offset_ns_;
    camera.capture_ns += clock_offset_ns_;
    append_row(rows, camera_columns, camera);
  }
  const auto& [pose, details, initialised] = mark.record;
  append_row(beat_.text(), beat_columns,
             BeatRow{.tick = pose.tick,
                     .time_ns = pose.time_ns + clock_offset_ns_,
                     .woke_ns = mark.woke_ns + clock_offset_ns_,
                     .frames = std::to_array(details.frames),
                     .camera_messages = details.camera_messages,
                     .camera_poses = counts_.cameras,
                     .conditions = mark.conditions,
                     .realtime_offset_ns = std::to_string(mark.realtime_offset_ns),
                     .record = fmt::format("{:016x}", daemon::fingerprint(mark.record))});
  counts_.last_tick = mark.record.pose.tick;
  if (first) return;
  ++counts_.ticks;
  if (mark.record.initialised)
    append_record_row(poses_.text(), mark.record, mark.record.pose.time_ns + clock_offset_ns_);
}

void RecordingFolder::flush() {
  for (GrowingFile* file : {&frames_, &cameras_}) file->write();
  for (GrowingFile* file : {&frames_, &cameras_}) file->sync();
  for (GrowingFile* file : {&beat_, &poses_}) file->write();
  for (GrowingFile* file : {&beat_, &poses_}) file->sync();
}

void RecordingFolder::close(const std::string& why) {
  flush();
  write_info(why);
}

std::uint64_t RecordingFolder::bytes() const {
  return frames_.bytes() + cameras_.bytes() + beat_.bytes() + poses_.bytes();
}

void RecordingFolder::write_info(const std::string& end) {
  utsname machine{};
  ::uname(&machine);
  nlohmann::ordered_json info{{"format", recording_format}, {"started", started_}};
  info.update(start_.hello);
  info["buses"] = start_.buses;
  info["host"] = machine.nodename;
  info["kernel"] = fmt::format("{} {} {}", machine.release, machine.version, machine.machine);
  info["clock_offset_ns"] = clock_offset_ns_;
  info["initial_pose"] = initial_;
  info["first_tick"] = counts_.first_tick;
  if (!end.empty()) {
    info["last_tick"] = counts_.last_tick;
    info["ticks"] = counts_.ticks;
    info["frames"] = counts_.frames;
    info["camera_poses"] = counts_.cameras;
    info["end"] = end;
  }
  // Writes the file completely or not at all.
  const auto path = folder_ / recorded_info;
  const auto fresh = folder_ / "info.json.part";
  write_whole(fresh, info.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
  std::filesystem::rename(fresh, path);
}

}  // namespace odomd::tools
