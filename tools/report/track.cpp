#include "tools/report/track.hpp"

#include <chrono>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/attach.hpp"
#include "tools/live/tick_follower.hpp"

namespace odomd::tools {
namespace {

Track track_of(std::string text, const std::string& name, Frame frame,
               const std::vector<std::string>& further) {
  Track track;
  track.columns.resize(further.size());
  std::istringstream input{std::move(text)};
  track.trajectory = read_trajectory(input, name, frame);
  if (further.empty()) return track;
  input.clear();
  input.seekg(0);
  CsvReader reader{input, name, {"t"}, further};
  while (reader.next()) {
    track.times_ns.push_back(reader.time_ns(0));
    for (std::size_t i = 0; i < further.size(); ++i) {
      if (reader.has(1 + i)) track.columns[i].push_back(reader.number(1 + i));
    }
  }
  return track;
}

}  // namespace

Track read_track(const std::filesystem::path& file, Frame frame,
                 const std::vector<std::string>& further) {
  auto input = open_input(file);
  return track_of({std::istreambuf_iterator<char>(input), {}}, file.string(), frame, further);
}

LiveTrack follow_daemon(const std::string& shm, double seconds, Frame frame,
                        const std::vector<std::string>& further) {
  using std::chrono::steady_clock;
  std::ostringstream header;
  write_record_header(header);
  std::string text = header.str();
  TickFollower follower{attach(shm, 0.0)};
  Interrupt interrupt;
  daemon::TickRecord record;
  const auto end = steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!interrupt.requested() && steady_clock::now() < end) {
    // Calibrations change slowly: the newest stand for all ticks that are handed out together.
    const auto newest = follower.client().latest_details();
    if (newest.has_value()) record.details = newest->details;
    (void)follower.follow(std::chrono::milliseconds{100}, [&](const odom_pose& pose) {
      if (pose.mode == ODOM_INITIALISING) return;
      record.pose = pose;
      append_record_row(text, record, pose.time_ns);
    });
  }
  const std::string name = segment_asked_for(shm);
  if (text.size() == header.str().size()) {
    throw std::runtime_error(name + ": no pose was published; check odom status");
  }
  LiveTrack live;
  if (const auto beat = follower.client().beat(); beat.has_value()) {
    live.beat = beat_histogram(*beat, name);
  }
  live.track = track_of(std::move(text), name, frame, further);
  return live;
}

}  // namespace odomd::tools
