#include "daemon/journal/error_sink.hpp"

#include <poll.h>

#include <cerrno>
#include <climits>
#include <string>

#include <fmt/format.h>

namespace odomd::daemon {

void ErrorSink::sink_it_(const spdlog::details::log_msg& message) {
  // A descriptor that is ready takes PIPE_BUF bytes without blocking.
  pollfd room{descriptor_, POLLOUT, 0};
  if (::poll(&room, 1, 0) == 0) {
    ++lost_;
    return;
  }
  std::string text;
  if (lost_ > 0) text = fmt::format("({} lines lost: standard error was not read)\n", lost_);
  spdlog::memory_buf_t line;
  formatter_->format(message, line);
  text.append(line.data(), line.size());
  if (text.size() > PIPE_BUF) {
    text.resize(PIPE_BUF);
    text.back() = '\n';
  }
  while (::write(descriptor_, text.data(), text.size()) < 0 && errno == EINTR) {
  }
  lost_ = 0;  // writing failed, so it cannot be reported either
}

}  // namespace odomd::daemon
