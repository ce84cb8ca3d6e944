// A log sink for standard error that never blocks: a reader that stops reading (a pager, a stopped
// terminal, a pipe to a hung program) must not block housekeeping, which also handles TERM.
#pragma once

#include <unistd.h>

#include <cstdint>

#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>

namespace odomd::daemon {

/// For one thread. Lines that do not fit are lost; once there is room, their number is reported.
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
