#include "shm_api/cut_short.hpp"

#include <unistd.h>
#include <atomic>
#include <cstdlib>
#include <cstring>

namespace odomd::shm {
namespace {

// Static, since a signal handler has no parameter for it.
const char* name_of_program = "odom";

void say(const char* text) noexcept {
  if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) {
    // Writing failed, so the error cannot be reported.
  }
}

extern "C" void on_bus_error(int signal, siginfo_t* info, void* /*context*/) {
  end_if_cut_short(*info);
  // Another cause: restore the default action, which the retried access then triggers.
  static_cast<void>(std::signal(signal, SIG_DFL));
}

}  // namespace

void end_where_a_segment_is_cut_short(const char* program) {
  name_of_program = program;
  struct sigaction action {};
  action.sa_sigaction = on_bus_error;
  action.sa_flags = SA_SIGINFO;
  ::sigaction(SIGBUS, &action, nullptr);
}

void end_if_cut_short(const siginfo_t& info) noexcept {
  if (info.si_code != BUS_ADRERR) return;
  // Several threads may be here simultaneously: the first one writes the line and ends the process.
  static std::atomic_flag said;
  while (said.test_and_set()) ::pause();
  say(name_of_program);
  say(": the segment was truncated while it was in use (SIGBUS): only odomd may write to its file; "
      "start again\n");
  ::_exit(EXIT_FAILURE);
}

}  // namespace odomd::shm
