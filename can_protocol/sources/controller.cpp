#include "can_protocol/sources/controller.hpp"

#include <libsocketcan.h>
#include <unistd.h>
#include <csignal>
#include <ctime>

#include <array>
#include <cstdio>
#include <memory>
#include <utility>

namespace odomd::can {
namespace {

constexpr std::array<std::string_view, CAN_STATE_MAX> health_names{
    "error_active", "error_warning", "error_passive", "bus_off", "stopped", "sleeping"};

/// Indexed by the bits of can_ctrlmode.flags.
constexpr std::array<std::string_view, 11> mode_names{
    "loopback",    "listen_only", "triple_sampling", "one_shot", "bus_error_reporting", "fd",
    "presume_ack", "fd_non_iso",  "cc_len8_dlc",     "tdc_auto", "tdc_manual"};

/// Redirects the C library's `stderr`, a variable in glibc, to /dev/null for the lifetime of the
/// object.
class MuteStandardError {
 public:
  MuteStandardError() : nowhere_(std::fopen("/dev/null", "w")) {
    if (nowhere_) stderr = nowhere_.get();
  }
  ~MuteStandardError() { stderr = saved_; }
  MuteStandardError(const MuteStandardError&) = delete;
  MuteStandardError& operator=(const MuteStandardError&) = delete;

 private:
  struct Close {
    void operator()(FILE* file) const { static_cast<void>(std::fclose(file)); }
  };
  FILE* saved_ = stderr;
  std::unique_ptr<FILE, Close> nowhere_;
};

/// Interrupts system calls of the calling thread repeatedly for the lifetime of the object. Without
/// it, libsocketcan would wait for ever if an interface disappeared between the look-up of its name
/// and the query.
class Impatience {
 public:
  Impatience() {
    // SIGURG is ignored by default: only a handler without SA_RESTART interrupts a system call.
    struct sigaction nothing {};
    nothing.sa_handler = [](int) {};
    ::sigaction(SIGURG, &nothing, nullptr);
    sigevent event{};
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = SIGURG;
    event._sigev_un._tid = ::gettid();
    running_ = ::timer_create(CLOCK_MONOTONIC, &event, &timer_) == 0;
    const itimerspec every{{0, timeout_ns}, {0, timeout_ns}};
    if (running_) ::timer_settime(timer_, 0, &every, nullptr);
  }
  ~Impatience() {
    if (running_) ::timer_delete(timer_);
  }
  Impatience(const Impatience&) = delete;
  Impatience& operator=(const Impatience&) = delete;

 private:
  static constexpr long timeout_ns = 500'000'000;
  timer_t timer_{};
  bool running_ = false;
};

/// The result of one libsocketcan query, empty when there is none.
template <typename Answer>
std::optional<Answer> ask(int (*question)(const char*, Answer*), const std::string& interface) {
  Answer answer{};
  if (question(interface.c_str(), &answer) != 0) return std::nullopt;
  return answer;
}

std::vector<std::string_view> modes_in(std::uint32_t flags) {
  std::vector<std::string_view> modes;
  for (std::size_t bit = 0; bit < mode_names.size(); ++bit)
    if ((flags >> bit & 1U) != 0) modes.push_back(mode_names[bit]);
  return modes;
}

}  // namespace

std::string_view name_of(ControllerHealth health) noexcept {
  return health_names[static_cast<std::size_t>(health)];
}

std::optional<Controller> read_controller(const std::string& interface) {
  const MuteStandardError mute;
  const Impatience impatience;
  const auto state = ask(can_get_state, interface);
  if (!state || *state < 0 || *state >= CAN_STATE_MAX) return std::nullopt;

  Controller controller;
  controller.health = static_cast<ControllerHealth>(*state);
  controller.restart_ms = ask(can_get_restart_ms, interface);
  if (const auto timing = ask(can_get_bittiming, interface); timing && timing->bitrate != 0)
    controller.bit_timing = timing;
  if (const auto clock = ask(can_get_clock, interface); clock && clock->freq != 0)
    controller.clock_hz = clock->freq;
  if (const auto mode = ask(can_get_ctrlmode, interface)) controller.modes = modes_in(mode->flags);
  controller.errors = ask(can_get_berr_counter, interface);
  controller.statistics = ask(can_get_device_stats, interface);
  return controller;
}

}  // namespace odomd::can
