#include "tools/cli/output.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstddef>
#include <iostream>
#include <system_error>
#include <utility>

#include "base/printable.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

constexpr int look_every_ms = 50;
constexpr int looks_after_stop = 20;  // 1 s: a reader that still reads gets the rest

// A pipe that is ready accepts this much without blocking; a file never blocks.
std::size_t piece_for(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) ? SSIZE_MAX : PIPE_BUF;
}

/// A longer line would wrap, and only its last part be overwritten. Each byte counts as a column.
std::string cut_to_terminal(const std::string& text) {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return text;
  return shortened(text, size.ws_col - 2U);
}

}  // namespace

bool stop_is_asked() {
  sigset_t pending;
  sigemptyset(&pending);
  sigpending(&pending);
  return sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1 ||
         sigismember(&pending, SIGHUP) == 1;
}

int write_all(int descriptor, std::string_view text) {
  const std::size_t piece = piece_for(descriptor);
  for (int looks = 0; !text.empty();) {
    pollfd room{descriptor, POLLOUT, 0};
    const int ready = ::poll(&room, 1, look_every_ms);
    if (ready == 0) {
      if (stop_is_asked() && ++looks > looks_after_stop) return ECANCELED;
      continue;
    }
    const ssize_t written =
        ready < 0 ? -1 : ::write(descriptor, text.data(), std::min(text.size(), piece));
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR && errno != EAGAIN) {
      return errno;
    }
  }
  return 0;
}

std::string why_not_written(int error) {
  if (error == ECANCELED) return "nobody was reading when INT or TERM came; the rest is lost";
  return std::generic_category().message(error);
}

OutputBuffer::OutputBuffer(int descriptor)
    : descriptor_(descriptor), terminal_(::isatty(descriptor) != 0) {}

OutputBuffer::int_type OutputBuffer::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char one = traits_type::to_char_type(c);
  return xsputn(&one, 1) == 1 ? c : traits_type::eof();
}

std::streamsize OutputBuffer::xsputn(const char* text, std::streamsize size) {
  constexpr std::size_t enough = 65'536;
  const std::string_view added(text, static_cast<std::size_t>(size));
  if (error_ == 0) waiting_ += added;
  // Whole lines, so that no character is split.
  if ((terminal_ || waiting_.size() >= enough) && added.find('\n') != std::string_view::npos) {
    std::string rest = waiting_.substr(waiting_.rfind('\n') + 1);
    waiting_.resize(waiting_.size() - rest.size());
    sync();
    waiting_ = std::move(rest);
  }
  if (error_ == 0) return size;
  errno = error_;
  return 0;
}

int OutputBuffer::sync() {
  if (error_ == 0) error_ = write_all(descriptor_, escaped(waiting_, LineBreaks::kept));
  waiting_.clear();
  if (error_ == 0) return 0;
  errno = error_;
  return -1;
}

StandardStreams::StandardStreams()
    : out_(STDOUT_FILENO),
      error_(STDERR_FILENO),
      out_before_(std::cout.rdbuf(&out_)),
      error_before_(std::cerr.rdbuf(&error_)) {}

StandardStreams::~StandardStreams() {
  std::cout.flush();
  std::cerr.flush();
  std::cout.rdbuf(out_before_);
  std::cerr.rdbuf(error_before_);
}

void say(std::string_view text) {
  std::cerr << one_line(text) + "\n" << std::flush;
}

void warn(std::string_view command, std::string_view text) {
  say("odom " + std::string{command} + ": warning: " + std::string{text});
}

void draw(std::string_view text) {
  std::cerr.flush();
  static_cast<void>(write_all(STDERR_FILENO, text));
}

Interrupt::Interrupt() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

Interrupt::~Interrupt() {
  if (!requested()) pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool Interrupt::requested() {
  requested_ = requested_ || stop_is_asked();
  return requested_;
}

ProgressLine::ProgressLine(std::string who, WithoutTerminal without)
    : who_(std::move(who)),
      without_(without),
      terminal_(::isatty(STDERR_FILENO) != 0),
      interval_(terminal_                                  ? 100
                : without == WithoutTerminal::every_second ? 1'000
                                                           : 10'000),
      next_(steady_clock::now() +
            (interval_.count() < 10'000 ? std::chrono::milliseconds{} : interval_)) {}

ProgressLine::~ProgressLine() {
  end();
}

void ProgressLine::show(const std::string& text) {
  const auto now = steady_clock::now();
  if (now < next_) return;
  next_ = now + interval_;
  if (terminal_) {
    draw('\r' + cut_to_terminal(escaped(text)) + "\x1b[K");
    shown_ = true;
  } else if (without_ != WithoutTerminal::nothing) {
    say(who_ + ": " + text);
  }
}

void ProgressLine::end() {
  if (shown_) draw("\n");
  shown_ = false;
}

void ProgressLine::finish(const std::string& text) {
  next_ = {};
  show(text);
  end();
}

}  // namespace odomd::tools
