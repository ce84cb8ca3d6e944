// Standard error as a sink of the log that never waits: nobody who stops reading (a pager, a
// terminal that was stopped, a pipe to a hung program) holds up housekeeping, and with it TERM.
#pragma once

#include <unistd.h>

#include <cstdint>

#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>

namespace odomd::daemon {

/// One thread. Lines that there is no room for are lost, and told once there is.
class ErrorSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  explicit ErrorSink(int descriptor = STDERR_FILENO) : descriptor_(descriptor) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

  int descriptor_;
  std::uint64_t lost_ = 0;
};

}  // namespace odomd::daemon
