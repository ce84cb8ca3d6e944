// Applies several faults together to a stream of frames or camera poses, and to whole logs.
//
//   Injector injector(config, databases, bus_names, faults);
//   injector.take(frame, out);  // appends the frames that are due by now
//   injector.release(end_of_time, out);
#pragma once

#include <cstdint>
#include <iosfwd>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/output.hpp"
#include "tools/fault/stream_faults.hpp"

namespace odomd::fault {

inline constexpr std::int64_t end_of_time = std::numeric_limits<std::int64_t>::max();

/// A fault, and the number of frames or poses that it affected.
struct Acted {
  Fault fault;
  std::uint64_t count = 0;
};

/// Applies faults one after the other, in the given order; each has a `Stage` for `Item`s.
template <typename Stage, typename Item>
class Chain {
 public:
  explicit Chain(std::vector<Fault> faults) : faults_(std::move(faults)) {}

  /// `stage_for` makes the stage of a fault.
  template <typename StageFor>
  void start(StageFor stage_for) {
    stages_.clear();
    for (const Fault& fault : faults_) stages_.push_back(stage_for(fault));
  }

  /// Takes a frame or pose and appends the items that are due by its time.
  void take(const Item& item, std::vector<Item>& out) {
    in_.assign(1, item);
    pass(0, out);
  }
  /// Appends the held-back items that are due by `now_ns`.
  void release(std::int64_t now_ns, std::vector<Item>& out) {
    for (std::size_t stage = 0; stage < stages_.size(); ++stage) {
      in_.clear();
      stages_[stage].release(now_ns, in_);
      pass(stage + 1, out);
    }
  }

  [[nodiscard]] std::vector<Acted> acted() const {
    std::vector<Acted> result;
    for (std::size_t i = 0; i < faults_.size(); ++i)
      result.push_back({faults_[i], i < stages_.size() ? stages_[i].acted_on() : 0});
    return result;
  }

 private:
  // Passes the contents of in_ through all stages from the given one on.
  void pass(std::size_t stage, std::vector<Item>& out) {
    for (; stage < stages_.size(); ++stage) {
      next_.clear();
      for (const Item& item : in_) stages_[stage].take(item, next_);
      in_.swap(next_);
    }
    out.insert(out.end(), in_.begin(), in_.end());
  }

  std::vector<Fault> faults_;
  std::vector<Stage> stages_;
  std::vector<Item> in_, next_;
};

/// Applies the camera's faults to a stream of its poses; ignores other faults.
class CameraInjector : public Chain<CameraFault, estimator::CameraPose> {
 public:
  CameraInjector(std::span<const Fault> faults, std::int64_t start_ns);
};

/// Applies all faults except the camera's to a stream of frames.
class Injector : public Chain<FrameFault, can::Frame> {
 public:
  /// Throws std::invalid_argument if the configuration does not fit the databases, or does not map
  /// the source of a fault: the message names the key.
  Injector(const daemon::Config& config, std::span<const can::Database> databases,
           std::span<const std::string> bus_names, std::span<const Fault> faults);

  /// Sets the origin of the faults' times; by default it is the stamp of the first frame.
  void start(std::int64_t start_ns);

  void take(const can::Frame& frame, std::vector<can::Frame>& out);

 private:
  CarSignals signals_;
  std::array<double, estimator::source_count> sigma_{};
  bool started_ = false;
};

/// Throws std::invalid_argument if the configuration does not map the source of a fault.
void require_mapped(const daemon::Config& config, std::span<const Fault> faults);

struct Streamed {
  std::uint64_t in = 0;
  std::uint64_t out = 0;
  std::int64_t first_ns = 0;  ///< stamp of the first received
};

enum class Flush : std::uint8_t { at_the_end, every_frame };

/// Writes the output of the injector like candump -L: stamps in microseconds, or in nanoseconds if
/// the input has them. Throws like LogReader, and std::runtime_error if it cannot write.
Streamed write_log(can::LogReader& log, const can::BusNames& buses, Injector& injector,
                   std::ostream& out, Flush flush, const tools::ReportProgress& progress);

/// Writes a camera log with its header.
Streamed write_camera_log(const std::vector<estimator::CameraPose>& poses, CameraInjector& injector,
                          std::ostream& out);

}  // namespace odomd::fault
