#include "daemon/housekeeping/process_control.hpp"

#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>
#include <csignal>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

#include "shm_api/cut_short.hpp"

namespace odomd::daemon {
namespace {

constexpr std::array handled{SIGTERM, SIGINT, SIGHUP};

/// The signals of faults: ignoring one would let the program run on in an invalid state.
constexpr std::array faults{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS};

/// Signals that stop and continue a process, or do nothing by default.
constexpr std::array harmless{SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU,
                              SIGCONT, SIGCHLD, SIGURG,  SIGWINCH};

bool is_one_of(const auto& signals, int signal) {
  return std::ranges::find(signals, signal) != signals.end();
}

}  // namespace

FileDescriptor take_signals() {
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    if (is_one_of(handled, signal) || is_one_of(faults, signal) || is_one_of(harmless, signal))
      continue;
    static_cast<void>(::signal(signal, SIG_IGN));  // fails for KILL and libc's own
  }
  // libc reserves two signals for pthread_cancel and setuid, which odomd does not call, and does
  // not let a program ignore them; the system call does. The call's struct begins with the handler;
  // the rest may be zero.
  const std::array<std::uintptr_t, 8> ignored{reinterpret_cast<std::uintptr_t>(SIG_IGN)};
  for (int signal = 32; signal < SIGRTMIN; ++signal)
    ::syscall(SYS_rt_sigaction, signal, ignored.data(), nullptr, sizeof(std::uint64_t));
  shm::end_where_a_segment_is_cut_short("odomd");

  sigset_t set;
  sigemptyset(&set);
  for (const int signal : handled) sigaddset(&set, signal);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  FileDescriptor descriptor(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
  if (!descriptor) throw std::system_error(errno, std::generic_category(), "signalfd");
  return descriptor;
}

Watchdog::Watchdog() {
  std::uint64_t limit_us = 0;
  // A third of the limit: one notification may be late.
  if (::sd_watchdog_enabled(0, &limit_us) > 0)
    notify_every_ns_ = static_cast<std::int64_t>(limit_us) * 1000 / 3;
}

void Watchdog::notify(std::uint64_t ticks, std::int64_t now_ns) {
  if (notify_every_ns_ == 0 || now_ns - last_notified_ns_ < notify_every_ns_ ||
      ticks == last_ticks_)
    return;
  last_notified_ns_ = now_ns;
  last_ticks_ = ticks;
  ::sd_notify(0, "WATCHDOG=1");
}

}  // namespace odomd::daemon
