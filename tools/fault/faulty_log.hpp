// Logs with faults in them: a candump log, and a camera log, from one stream to another.
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
  std::int64_t first_ns = 0;  ///< stamps of the first and the last that came in
  std::int64_t last_ns = 0;
};

enum class Flush : std::uint8_t { at_the_end, every_frame };

/// Writes what leaves the injector, as candump -L does: stamps in microseconds, in nanoseconds
/// where they have such. Throws as LogReader does, and std::runtime_error where nothing can be
/// written any more.
Streamed write_log(can::LogReader& log, const can::BusNames& buses, Injector& injector,
                   std::ostream& out, Flush flush, const tools::TellProgress& progress);

/// The rows of a camera log, with their header.
Streamed write_camera_log(const std::vector<estimator::CameraPose>& poses, CameraInjector& injector,
                          std::ostream& out);

}  // namespace odomd::fault
