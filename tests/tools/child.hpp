// One of the project's programs, which runs in parallel with a test of the tools.
#pragma once

#include "tests/process.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools {

class Child : public Process {
 public:
  /// The program's outputs go to new files, except for the stream in `stream_to` (see Process).
  Child(const Scratch& scratch, const std::string& program, std::vector<std::string> arguments,
        std::pair<int, int> stream_to = {-1, -1})
      : Process(words(program, std::move(arguments)), anew(scratch.path("child.out")),
                anew(scratch.path("child.err")), stream_to),
        out_(scratch.path("child.out")),
        err_(scratch.path("child.err")) {}

  /// Sends SIGTERM and waits until the program ends.
  Outcome terminate() {
    signal(SIGTERM);
    return wait();
  }
  Outcome wait() {
    const int status = Process::wait();
    return {status, contents(out_), contents(err_)};
  }
  [[nodiscard]] std::string errors() const { return contents(err_); }

 private:
  static std::vector<std::string> words(const std::string& program,
                                        std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), ODOMD_BIN_DIR "/" + program);
    return arguments;
  }
  static std::filesystem::path anew(const std::filesystem::path& file) {
    std::filesystem::remove(file);
    return file;
  }

  std::filesystem::path out_, err_;
};

}  // namespace odomd::tools
