// A program of ours that runs beside a test.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/tools/scratch.hpp"

namespace odomd::tools {

/// Tries `condition` until it holds; false after a minute of trying.
[[nodiscard]] inline bool eventually(const std::function<bool()>& condition,
                                     std::chrono::milliseconds pause = std::chrono::milliseconds{
                                         5}) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes{1};
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(pause);
  }
  return true;
}

/// One of our programs as a process; its output goes to files, except for a stream that goes to
/// a descriptor: {STDOUT_FILENO, pipe}.
class Child {
 public:
  Child(const Scratch& scratch, const std::string& program, std::vector<std::string> arguments,
        std::pair<int, int> stream_to = {-1, -1})
      : out_(scratch.path("child.out")), err_(scratch.path("child.err")) {
    const std::string path = std::string(ODOMD_BIN_DIR) + "/" + program;
    arguments.insert(arguments.begin(), path);
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files{};
    ::posix_spawn_file_actions_init(&files);
    constexpr int write_anew = O_WRONLY | O_CREAT | O_TRUNC;
    ::posix_spawn_file_actions_addopen(&files, 1, out_.c_str(), write_anew, 0600);
    ::posix_spawn_file_actions_addopen(&files, 2, err_.c_str(), write_anew, 0600);
    if (stream_to.first >= 0)
      ::posix_spawn_file_actions_adddup2(&files, stream_to.second, stream_to.first);
    const int error = ::posix_spawn(&pid_, path.c_str(), &files, nullptr, argv.data(), environ);
    ::posix_spawn_file_actions_destroy(&files);
    if (error != 0) throw std::runtime_error(path + ": " + std::strerror(error));
  }
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Sends SIGTERM and waits until it ends.
  Outcome terminate() {
    ::kill(pid_, SIGTERM);
    return wait();
  }
  Outcome wait() {
    int raw = 0;
    Outcome outcome;
    if (eventually([&] { return ::waitpid(pid_, &raw, WNOHANG) == pid_; })) {
      pid_ = -1;
      outcome.status = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
    }
    outcome.out = contents(out_);
    outcome.err = contents(err_);
    return outcome;
  }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] std::string errors() const { return contents(err_); }

 private:
  std::filesystem::path out_;
  std::filesystem::path err_;
  pid_t pid_ = -1;
};

}  // namespace odomd::tools
