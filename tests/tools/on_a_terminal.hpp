// An odom command whose standard streams are a terminal of the test.
#pragma once

#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

#include "base/file_descriptor.hpp"
#include "tests/gtest.hpp"

namespace odomd::tools {

class OnATerminal {
 public:
  explicit OnATerminal(const std::string& command, unsigned short columns = 80) {
    int master = -1;
    const winsize size{24, columns, 0, 0};
    pid_ = ::forkpty(&master, nullptr, nullptr, &size);
    if (pid_ == 0) {
      const std::string line = "exec " ODOMD_BIN_DIR "/odom " + command;
      ::setenv("TERM", "xterm", 1);
      ::setenv("LC_ALL", "C.UTF-8", 1);
      ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      ::_exit(127);
    }
    master_ = FileDescriptor{master};
  }
  ~OnATerminal() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }
  OnATerminal(const OnATerminal&) = delete;
  OnATerminal& operator=(const OnATerminal&) = delete;

  void press(std::string_view keys) const {
    ASSERT_EQ(::write(master_.get(), keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  void signal(int number) const { ::kill(pid_, number); }

  /// Reads on until the text appears; false if it does not.
  [[nodiscard]] bool shows(std::string_view text) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{60};
    while (std::chrono::steady_clock::now() < deadline) {
      if (has_shown(text)) return true;
      if (!read_some(1000)) return false;
    }
    return false;
  }
  /// Whether the text appears in the output so far, after the text that was found before.
  [[nodiscard]] bool has_shown(std::string_view text) {
    read_some(0);
    const auto at = seen_.find(text, from_);
    if (at == std::string::npos) return false;
    from_ = at + text.size();
    return true;
  }

  /// Reads all output. Returns the command's exit status, or 128 + the signal that ended it.
  [[nodiscard]] int end() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{60};
    while (std::chrono::steady_clock::now() < deadline && read_some(1000)) {
    }
    int raw = 0;
    ::waitpid(pid_, &raw, 0);
    pid_ = -1;
    return WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
  }
  [[nodiscard]] const std::string& seen() const { return seen_; }

 private:
  // Waits for output; false if the other side has closed.
  bool read_some(int milliseconds) {
    pollfd ready{master_.get(), POLLIN, 0};
    if (::poll(&ready, 1, milliseconds) <= 0) return true;
    char bytes[4096];
    const auto size = ::read(master_.get(), bytes, sizeof bytes);
    if (size <= 0) return false;
    seen_.append(bytes, static_cast<std::size_t>(size));
    return true;
  }

  pid_t pid_ = -1;
  FileDescriptor master_;
  std::string seen_;
  std::size_t from_ = 0;
};

}  // namespace odomd::tools
