// Adds faults to logs: a candump log and a camera log, from one stream to another.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/progress.hpp"
#include "tools/fault/camera_fault.hpp"
#include "tools/fault/injector.hpp"

namespace odomd::fault {

struct Streamed {
  std::uint64_t in = 0;
  std::uint64_t out = 0;
  std::int64_t first_ns = 0;  ///< stamps of the first and the last received
  std::int64_t last_ns = 0;
};

enum class Flush : std::uint8_t { at_the_end, every_frame };

/// Writes the output of the injector like candump -L: stamps in microseconds, or in nanoseconds if
/// they have them. Throws like LogReader, and std::runtime_error if it cannot write.
Streamed write_log(can::LogReader& log, const can::BusNames& buses, Injector& injector,
                   std::ostream& out, Flush flush, const tools::ReportProgress& progress);

/// The rows of a camera log, with their header.
Streamed write_camera_log(const std::vector<estimator::CameraPose>& poses, CameraInjector& injector,
                          std::ostream& out);

}  // namespace odomd::fault
