#include "tools/live/watch/terminal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <regex>
#include <stdexcept>

#include "shm_api/cut_short.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools::watch {
namespace {

constexpr std::array<std::pair<std::string_view, Key>, 9> codes{{{"q", Key::quit},
                                                                 {"p", Key::pause},
                                                                 {" ", Key::pause},
                                                                 {"\x1b[A", Key::up},
                                                                 {"\x1bOA", Key::up},
                                                                 {"\x1b[B", Key::down},
                                                                 {"\x1bOB", Key::down},
                                                                 {"\x1b[5~", Key::page_up},
                                                                 {"\x1b[6~", Key::page_down}}};

// Alternate screen, no cursor, no wrapping at the right edge; and the sequence that undoes this.
constexpr std::string_view enter_sequence = "\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J";
constexpr std::string_view leave_sequence = "\x1b[?7h\x1b[?25h\x1b[0m\x1b[?1049l";

constexpr std::array crashes{SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

// State for the signal handler, which takes no arguments.
struct {
  volatile std::sig_atomic_t armed = 0;
  bool keyboard = false;
  termios settings{};
} to_restore;

// Async-signal-safe. The signal's default action follows, through SA_RESETHAND.
extern "C" void give_terminal_back(int signal, siginfo_t* info, void* /*context*/) {
  if (to_restore.armed != 0) {
    to_restore.armed = 0;
    if (::write(STDOUT_FILENO, leave_sequence.data(), leave_sequence.size()) < 0) {
      // Nobody is left to whom a failure could be reported.
    }
    if (to_restore.keyboard) ::tcsetattr(STDIN_FILENO, TCSANOW, &to_restore.settings);
  }
  if (signal == SIGBUS) shm::end_if_cut_short(*info);
  static_cast<void>(::raise(signal));
}

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view{} : std::string_view{value};
}

}  // namespace

std::vector<Key> keys_in(std::string_view bytes) {
  static const std::regex sequence_or_character{"\x1b[[O][^A-Za-z~]*[A-Za-z~]?|[\\s\\S]"};
  std::vector<Key> keys;
  for (std::cregex_iterator at(bytes.begin(), bytes.end(), sequence_or_character), end; at != end;
       ++at) {
    const auto* const found =
        std::ranges::find(codes, at->str(), &decltype(codes)::value_type::first);
    if (found != codes.end()) keys.push_back(found->second);
  }
  return keys;
}

Terminal::Terminal(Colour colour) : colour_(colour), keyboard_(::isatty(STDIN_FILENO) != 0) {
  if (keyboard_ && ::tcgetattr(STDIN_FILENO, &before_) != 0) {
    throw std::runtime_error(std::string{"the terminal cannot be read: "} + std::strerror(errno));
  }
  sigset_t held;
  sigemptyset(&held);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGWINCH, SIGTSTP}) sigaddset(&held, signal);
  ::sigprocmask(SIG_BLOCK, &held, &signals_before_);
  signals_ = FileDescriptor{::signalfd(-1, &held, SFD_NONBLOCK | SFD_CLOEXEC)};
  struct sigaction action {};
  action.sa_sigaction = give_terminal_back;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_SIGINFO;
  for (const int signal : crashes) ::sigaction(signal, &action, nullptr);
  enter();
}

Terminal::~Terminal() {
  leave();
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  for (const int signal : crashes) ::sigaction(signal, &action, nullptr);
  ::sigprocmask(SIG_SETMASK, &signals_before_, nullptr);
}

void Terminal::enter() {
  shown_.clear();
  if (keyboard_) {
    termios settings = before_;
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    settings.c_cc[VMIN] = 0;
    settings.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &settings);
  }
  to_restore.keyboard = keyboard_;
  to_restore.settings = before_;
  to_restore.armed = 1;
  static_cast<void>(write_all(STDOUT_FILENO, enter_sequence));
}

void Terminal::leave() {
  to_restore.armed = 0;
  const bool taken = write_all(STDOUT_FILENO, leave_sequence) == 0;
  // Does not wait for a blocked terminal.
  if (keyboard_) ::tcsetattr(STDIN_FILENO, taken ? TCSADRAIN : TCSANOW, &before_);
}

std::pair<std::size_t, std::size_t> Terminal::size() {
  winsize window{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0 || window.ws_row == 0)
    return {80, 24};
  return {window.ws_col, window.ws_row};
}

void Terminal::show(const Lines& lines) {
  std::string text;
  if (shown_.size() != lines.size()) {
    shown_.assign(lines.size(), {});
    text = "\x1b[2J";
  }
  for (std::size_t row = 0; row < lines.size(); ++row) {
    std::string line = as_ansi(lines[row], colour_);
    if (line == shown_[row]) continue;
    text += "\x1b[" + std::to_string(row + 1) + ";1H" + line + "\x1b[K";
    shown_[row] = std::move(line);
  }
  static_cast<void>(write_all(STDOUT_FILENO, text));
}

Happened Terminal::wait(std::chrono::steady_clock::time_point until) {
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
  std::array<pollfd, 2> ready{pollfd{signals_.get(), POLLIN, 0},
                              pollfd{keyboard_ ? STDIN_FILENO : -1, POLLIN, 0}};
  ::poll(ready.data(), ready.size(), static_cast<int>(std::clamp<long>(left.count(), 0, 60'000)));

  Happened happened;
  signalfd_siginfo info{};
  while (::read(signals_.get(), &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
    if (info.ssi_signo == SIGWINCH) {
      shown_.clear();
    } else if (info.ssi_signo == SIGTSTP) {
      leave();
      static_cast<void>(::raise(SIGSTOP));
      enter();
    } else {
      happened.ended = true;
    }
  }
  if ((ready[1].revents & POLLIN) != 0) {
    std::array<char, 256> bytes{};
    const auto size = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (size > 0) happened.keys = keys_in({bytes.data(), static_cast<std::size_t>(size)});
  }
  if ((ready[1].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) happened.ended = true;
  return happened;
}

bool is_screen() {
  return ::isatty(STDOUT_FILENO) != 0 && variable("TERM") != "dumb" && !variable("TERM").empty();
}

Colour colour_wanted() {
  return variable("NO_COLOR").empty() ? Colour::on : Colour::off;
}

}  // namespace odomd::tools::watch
