// A program that runs in parallel with a test.
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
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/file_descriptor.hpp"

namespace odomd {

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

/// Its standard input is a pipe; its outputs are appended to files, except for a stream that goes
/// to a descriptor: {STDOUT_FILENO, pipe}.
class Process {
 public:
  Process(std::vector<std::string> words, const std::filesystem::path& out,
          const std::filesystem::path& err, std::pair<int, int> stream_to = {-1, -1}) {
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
    const FileDescriptor reader(ends[0]);
    input_ = FileDescriptor(ends[1]);
    posix_spawn_file_actions_t files{};
    ::posix_spawn_file_actions_init(&files);
    constexpr int append = O_WRONLY | O_CREAT | O_APPEND;
    ::posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
    ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out.c_str(), append, 0600);
    ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err.c_str(), append, 0600);
    if (stream_to.first >= 0)
      ::posix_spawn_file_actions_adddup2(&files, stream_to.second, stream_to.first);
    const int error = ::posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ);
    ::posix_spawn_file_actions_destroy(&files);
    if (error != 0) throw std::runtime_error(words[0] + ": " + std::strerror(error));
  }
  ~Process() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void feed(std::string_view text) const {
    for (ssize_t size = 0; !text.empty(); text.remove_prefix(static_cast<std::size_t>(size)))
      if ((size = ::write(input_.get(), text.data(), text.size())) <= 0) return;
  }
  void close_input() { input_ = {}; }
  void signal(int number) const { ::kill(pid_, number); }
  /// The program's exit status, or 128 + the signal that ended it; -1 if it does not end.
  [[nodiscard]] int wait() {
    int raw = 0;
    if (!eventually([&] { return ::waitpid(pid_, &raw, WNOHANG) == pid_; })) return -1;
    pid_ = -1;
    return WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  FileDescriptor input_;
};

}  // namespace odomd
