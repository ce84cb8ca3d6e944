#include "tools/sim/live.hpp"

#include <chrono>
#include <csignal>
#include <ctime>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <odom/odom.hpp>

#include "base/wall_clock.hpp"
#include "tools/cli/output.hpp"
#include "tools/live/camera_feed.hpp"
#include "tools/sim/can_output.hpp"

namespace odomd::sim {
namespace {

// Frames of a stretch are sent at its end, so they are at most this late.
constexpr std::int64_t stretch_ns = 1'000'000;
// Time between choosing the start time and the start, for opening files and sockets.
constexpr std::int64_t lead_ns = 200'000'000;

// During its lifetime, writing to a closed pipe is an error of write() instead of a signal.
class WithoutPipeSignal {
 public:
  WithoutPipeSignal() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~WithoutPipeSignal() { static_cast<void>(std::signal(SIGPIPE, before_)); }
  WithoutPipeSignal(const WithoutPipeSignal&) = delete;
  WithoutPipeSignal& operator=(const WithoutPipeSignal&) = delete;

 private:
  void (*before_)(int);
};

// The daemon's camera socket, opened as soon as it exists.
class CameraLine {
 public:
  CameraLine(std::filesystem::path socket, odom_clock clock)
      : socket_(std::move(socket)), clock_(clock) {}

  [[nodiscard]] bool wanted() const { return !socket_.empty(); }

  /// Returns whether the pose was delivered.
  bool send(const estimator::CameraPose& pose) {
    open_ = open_ || sender_.open(socket_.c_str()) == 0;
    return open_ && sender_.send(tools::camera_message(pose, clock_)) == 0;
  }

 private:
  std::filesystem::path socket_;
  odom_clock clock_;
  odom::CameraSender sender_;
  bool open_ = false;
};

}  // namespace

std::string progress_text(const Simulation& simulation) {
  const Driver& driver = simulation.driver();
  return fmt::format("{:.1f} s, {:.1f} of {:.1f} m ({:.0f} %), {:.2f} m/s",
                     1e-9 * static_cast<double>(simulation.time_ns()), driver.progress(),
                     driver.total(), 100.0 * driver.progress() / driver.total(),
                     simulation.plant().output().v_x);
}

std::int64_t live_start_ns() {
  return ((read_clock(CLOCK_REALTIME) + lead_ns) / truth_period_ns + 1) * truth_period_ns;
}

LiveSummary play_live(Simulation& simulation, const LiveOptions& options,
                      tools::ProgressLine& progress,
                      const std::function<void(const Happenings&)>& also) {
  const WithoutPipeSignal no_signal;
  tools::Interrupt interrupt;
  CanOutput output(options.can, options.decimals);
  CameraLine camera(options.camera_socket,
                    options.can == "-" ? ODOM_CLOCK_LOG : ODOM_CLOCK_REALTIME);
  LiveSummary summary;
  Happenings happenings;
  // Paced by the monotonic clock, which is never set.
  const std::int64_t start_ns = monotonic_now() + (options.start_ns - read_clock(CLOCK_REALTIME));
  RunState state = RunState::running;
  while (state == RunState::running) {
    happenings.clear();
    state = simulation.advance(simulation.time_ns() + stretch_ns, happenings);
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point{
        std::chrono::nanoseconds{start_ns + simulation.time_ns()}});
    if (interrupt.requested()) {
      summary.end = LiveEnd::interrupted;
      break;
    }
    output.send(happenings.frames);
    summary.frames += happenings.frames.size();
    if (camera.wanted())
      for (const estimator::CameraPose& pose : happenings.camera)
        ++(camera.send(pose) ? summary.camera_sent : summary.camera_dropped);
    also(happenings);
    progress.show(progress_text(simulation));
  }
  progress.finish(progress_text(simulation));
  return summary;
}

}  // namespace odomd::sim
