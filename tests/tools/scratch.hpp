// What tests of the tools share: a directory of their own, and running a program.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/gtest.hpp"

namespace odomd::tools {

/// A directory that lives as long as this object.
class Scratch {
 public:
  Scratch() {
    std::string path = (std::filesystem::temp_directory_path() / "odom_test.XXXXXX").string();
    if (::mkdtemp(path.data()) == nullptr) throw std::runtime_error("mkdtemp: " + path);
    directory_ = path;
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(directory_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] std::filesystem::path path(std::string_view name) const {
    return directory_ / name;
  }
  std::filesystem::path write(std::string_view name, std::string_view text) const {
    std::ofstream{path(name), std::ios::binary} << text;
    return path(name);
  }

 private:
  std::filesystem::path directory_;
};

inline std::string contents(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream{file, std::ios::binary}.rdbuf();
  return text.str();
}

struct Outcome {
  int status = -1;  ///< exit status, or 128 + the signal that ended it
  std::string out;
  std::string err;
};

/// Matches an outcome of this exit status whose standard error is, or matches, `err`.
inline ::testing::Matcher<const Outcome&> Ends(int status,
                                               const ::testing::Matcher<std::string>& err) {
  return ::testing::AllOf(::testing::Field("status", &Outcome::status, status),
                          ::testing::Field("err", &Outcome::err, err));
}

/// Runs a shell command line; `odom` in it is the built program.
inline Outcome run_shell(const std::string& command) {
  const Scratch scratch;
  const std::string line = "PATH=" ODOMD_BIN_DIR ":$PATH; (" + command + ") >" +
                           scratch.path("out").string() + " 2>" + scratch.path("err").string();
  const int raw = std::system(line.c_str());
  Outcome outcome;
  outcome.status = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
  outcome.out = contents(scratch.path("out"));
  outcome.err = contents(scratch.path("err"));
  return outcome;
}

/// Drives `odom sim` with these options into a folder of the directory; the folder.
inline std::string simulate(const Scratch& scratch, const std::string& options,
                            std::string_view name = "drive") {
  std::string folder = scratch.path(name).string();
  const Outcome outcome = run_shell("odom sim " + options + " --out " + folder);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return folder;
}

/// A simulated drive in a directory of its own, for all tests of a suite.
struct SharedDrive {
  explicit SharedDrive(const std::string& options, std::string_view name = "drive")
      : folder(simulate(scratch, options, name)) {}
  Scratch scratch;
  std::filesystem::path folder;
};

/// Runs each of the lines, after `before`. It must be refused: status 2, nothing on standard
/// output, and one line on standard error that is, or matches, the one given.
inline void expect_refused(
    const std::string& before,
    const std::vector<std::pair<std::string, ::testing::Matcher<std::string>>>& lines) {
  for (const auto& [line, error] : lines) {
    const Outcome outcome = run_shell(before + line);
    EXPECT_THAT(outcome, Ends(2, error)) << line << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "") << line;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << line << ": " << outcome.err;
  }
}

/// The message of the exception that `work` throws; empty when it throws none.
template <typename Work>
std::string message_of(Work&& work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

}  // namespace odomd::tools
