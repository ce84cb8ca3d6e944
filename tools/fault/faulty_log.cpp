#include "tools/fault/faulty_log.hpp"

#include <algorithm>
#include <ostream>
#include <stdexcept>

#include <fmt/format.h>

#include "can_protocol/sources/candump.hpp"
#include "tools/cli/files.hpp"
#include "tools/drive_files/camera_csv.hpp"

namespace odomd::fault {
namespace {

constexpr std::uint64_t frames_between_news = 10'000;

void append_line(std::string& text, const can::Frame& frame,
                 const std::vector<std::string>& names) {
  const bool micro = frame.time_ns % 1000 == 0;
  can::append_candump_line(text, frame, names[frame.bus],
                           micro ? can::StampDecimals::six : can::StampDecimals::nine);
}

void write(std::ostream& out, std::string& text, Flush flush) {
  out << text;
  if (flush == Flush::every_frame) out.flush();
  if (!out) throw std::runtime_error("the log cannot be written: " + tools::why_unwritten(out));
  text.clear();
}

}  // namespace

Streamed write_log(can::LogReader& log, const can::BusNames& buses, Injector& injector,
                   std::ostream& out, Flush flush, const tools::ReportProgress& progress) {
  Streamed streamed;
  std::vector<can::Frame> leaving;
  std::vector<std::string> names;
  std::string text;
  const auto write_leaving = [&] {
    for (const can::Frame& frame : leaving) {
      if (frame.bus >= names.size()) names = buses.all();
      append_line(text, frame, names);
    }
    streamed.out += leaving.size();
    leaving.clear();
    write(out, text, flush);
  };
  while (const can::Frame* const frame = log.next()) {
    if (streamed.in++ == 0) streamed.first_ns = frame->time_ns;
    streamed.last_ns = frame->time_ns;
    injector.take(*frame, leaving);
    write_leaving();
    if (streamed.in % frames_between_news == 0 && progress)
      progress(fmt::format("{:.0f} s, {} frames",
                           static_cast<double>(streamed.last_ns - streamed.first_ns) * 1e-9,
                           streamed.in));
  }
  injector.release(end_of_time, leaving);
  write_leaving();
  return streamed;
}

Streamed write_camera_log(const std::vector<estimator::CameraPose>& poses, CameraInjector& injector,
                          std::ostream& out) {
  Streamed streamed{.in = poses.size()};
  std::vector<estimator::CameraPose> leaving;
  for (const estimator::CameraPose& pose : poses) injector.take(pose, leaving);
  injector.release(end_of_time, leaving);
  std::ranges::stable_sort(leaving, {}, &estimator::CameraPose::arrival_ns);
  streamed.out = leaving.size();
  if (!poses.empty()) {
    streamed.first_ns = poses.front().arrival_ns;
    streamed.last_ns = poses.back().arrival_ns;
  }
  std::string text = std::string(tools::camera_columns) + '\n';
  for (const estimator::CameraPose& pose : leaving) tools::append_camera_row(text, pose);
  write(out, text, Flush::at_the_end);
  return streamed;
}

}  // namespace odomd::fault
