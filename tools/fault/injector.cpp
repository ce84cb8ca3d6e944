#include "tools/fault/injector.hpp"

#include <algorithm>
#include <iterator>
#include <ostream>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/sources/candump.hpp"
#include "daemon/core/config.hpp"
#include "tools/cli/files.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::fault {
namespace {

bool is_of_camera(const Fault& fault) {
  return fault.kind.part == Part::camera;
}

std::vector<Fault> faults_of(std::span<const Fault> all, bool camera) {
  std::vector<Fault> faults(all.begin(), all.end());
  std::erase_if(faults, [camera](const Fault& fault) { return is_of_camera(fault) != camera; });
  return faults;
}

constexpr std::uint64_t frames_per_report = 10'000;

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

void require_mapped(const daemon::Config& config, std::span<const Fault> faults) {
  for (const Fault& fault : faults) {
    if (fault.kind.part == Part::bus || is_of_camera(fault)) continue;
    const Sources sources = sources_of(fault.kind);
    const bool mapped = std::ranges::any_of(config.can.bindings, [&](const auto& binding) {
      return contains(sources, static_cast<estimator::Source>(binding.channel));
    });
    if (mapped) continue;
    throw std::invalid_argument(
        fmt::format("{}: [can.signals] maps no {}, which {} needs; map it there",
                    config.file.string(), fmt::join(names_of(sources), ", "), name_of(fault.kind)));
  }
}

CameraInjector::CameraInjector(std::span<const Fault> faults, std::int64_t start_ns)
    : Chain(faults_of(faults, true)) {
  start([&](const Fault& fault) { return CameraFault(fault, span_of(fault, start_ns)); });
}

Injector::Injector(const daemon::Config& config, std::span<const can::Database> databases,
                   std::span<const std::string> bus_names, std::span<const Fault> faults)
    : Chain(faults_of(faults, false)),
      signals_(config.can, databases, bus_names),
      sigma_(daemon::filter_settings(config).sigma) {
  require_mapped(config, faults);
}

void Injector::start(std::int64_t start_ns) {
  Chain::start([&](const Fault& fault) {
    return FrameFault(signals_, sigma_, fault, span_of(fault, start_ns));
  });
  started_ = true;
}

void Injector::take(const can::Frame& frame, std::vector<can::Frame>& out) {
  if (!started_) start(frame.time_ns);
  Chain::take(frame, out);
}

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
    injector.take(*frame, leaving);
    write_leaving();
    if (streamed.in % frames_per_report == 0 && progress)
      progress(fmt::format("{:.0f} s, {} frames",
                           static_cast<double>(frame->time_ns - streamed.first_ns) * 1e-9,
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
  auto text = tools::header_of<estimator::CameraPose>(tools::camera_columns);
  for (const estimator::CameraPose& pose : leaving) append_row(text, tools::camera_columns, pose);
  write(out, text, Flush::at_the_end);
  return streamed;
}

}  // namespace odomd::fault
