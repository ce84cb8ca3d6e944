#include "tools/sim/live.hpp"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <odom/odom.hpp>

#include "base/wall_clock.hpp"
#include "can_protocol/sources/candump.hpp"
#include "tools/cli/output.hpp"
#include "tools/live/daemon_feeds.hpp"

namespace odomd::sim {
namespace {

// Frames of a stretch are sent at its end, so they are at most this late.
constexpr std::int64_t stretch_ns = 1'000'000;
// Time between choosing the start time and the start, for opening files and sockets.
constexpr std::int64_t lead_ns = 200'000'000;

// A bus that accepts no frame for this time is considered dead.
constexpr int max_tries = 200;
constexpr std::chrono::milliseconds retry_delay{1};

FileDescriptor open_interface(const std::string& name) {
  const unsigned index = ::if_nametoindex(name.c_str());
  if (index == 0)
    throw std::invalid_argument(name +
                                ": no such CAN interface; ip link shows them, - is standard "
                                "output");
  FileDescriptor descriptor(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  if (!descriptor)
    throw std::runtime_error(name + ": CAN is not available here: " + std::strerror(errno));
  // An empty filter list: the socket receives nothing.
  ::setsockopt(descriptor.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
  // An interface without CAN FD reports this only when it is given a CAN FD frame to send.
  const int fd_frames = 1;
  ::setsockopt(descriptor.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &fd_frames, sizeof fd_frames);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (::bind(descriptor.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error(name + ": cannot be used as a CAN interface: " + std::strerror(errno));
  return descriptor;
}

canfd_frame to_kernel(const can::Frame& frame) {
  canfd_frame raw{};
  raw.can_id = frame.id;
  if (frame.format == can::IdFormat::extended) raw.can_id |= CAN_EFF_FLAG;
  if (frame.kind == can::FrameKind::remote) raw.can_id |= CAN_RTR_FLAG;
  raw.len = frame.length;
  raw.flags = frame.fd_flags;
  std::memcpy(raw.data, frame.data.data(), frame.length);
  return raw;
}

}  // namespace

CanOutput::CanOutput(const std::string& name) : name_(name) {
  if (name != "-") socket_ = open_interface(name);
}

void CanOutput::send(std::span<const can::Frame> frames) {
  if (socket_) {
    for (const can::Frame& frame : frames) transmit(frame);
    return;
  }
  text_.clear();
  for (const can::Frame& frame : frames) can::append_candump_line(text_, frame, log_interface);
  const int error = tools::write_all(STDOUT_FILENO, text_);
  if (error == EPIPE)
    throw std::runtime_error("standard output: the reader has gone; the drive ends here");
  if (error != 0) throw std::runtime_error("standard output: " + tools::why_not_written(error));
}

void CanOutput::transmit(const can::Frame& frame) {
  // A canfd_frame begins with the layout of a classic frame.
  const canfd_frame raw = to_kernel(frame);
  const std::size_t size = frame.protocol == can::FrameProtocol::fd ? CANFD_MTU : CAN_MTU;
  for (int tries = 0; ::write(socket_.get(), &raw, size) < 0; ++tries) {
    // The queue of the interface is full: the wire is slower than we are.
    if (errno != ENOBUFS && errno != EAGAIN && errno != EINTR)
      throw std::runtime_error(name_ + ": cannot send: " + std::strerror(errno));
    if (tries == max_tries)
      throw std::runtime_error(name_ +
                               ": accepts no more frames; is another node on the bus to "
                               "acknowledge them?");
    std::this_thread::sleep_for(retry_delay);
  }
}

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
  static_cast<void>(std::signal(SIGPIPE, SIG_IGN));
  tools::Interrupt interrupt;
  CanOutput output(options.can);
  const odom_clock camera_clock = options.can == "-" ? ODOM_CLOCK_LOG : ODOM_CLOCK_REALTIME;
  odom::CameraSender camera;
  bool camera_open = false;  // opened as soon as the socket exists
  LiveSummary summary;
  // Paced by the monotonic clock, which is never set.
  const std::int64_t start_ns = monotonic_now() + (options.start_ns - read_clock(CLOCK_REALTIME));
  RunState state = RunState::running;
  while (state == RunState::running) {
    Happenings happenings;
    state = simulation.advance(simulation.time_ns() + stretch_ns, happenings);
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point{
        std::chrono::nanoseconds{start_ns + simulation.time_ns()}});
    if (interrupt.requested()) {
      summary.end = LiveEnd::interrupted;
      break;
    }
    output.send(happenings.frames);
    for (const estimator::CameraPose& pose : happenings.camera) {
      if (options.camera_socket.empty()) break;
      camera_open = camera_open || camera.open(options.camera_socket.c_str()) == 0;
      const bool sent = camera_open && camera.send(tools::camera_message(pose, camera_clock)) == 0;
      ++(sent ? summary.camera_sent : summary.camera_dropped);
    }
    also(happenings);
    progress.show(progress_text(simulation));
  }
  progress.finish(progress_text(simulation));
  return summary;
}

}  // namespace odomd::sim
