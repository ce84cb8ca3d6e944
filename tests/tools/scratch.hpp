// What tests of the tools share: running a program in a directory of their own.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::tools {

using odomd::contents;
using odomd::message_of;
using odomd::Scratch;

struct Outcome {
  int status = -1;  ///< exit status, or 128 + the signal that ended it
  std::string out;
  std::string err;
};

/// Matches an outcome of this exit status whose standard error is, or matches, `err`.
inline ::testing::Matcher<const Outcome&> Ends(int status,
                                               const ::testing::Matcher<std::string>& err) {
  return AllOf(::testing::Field("status", &Outcome::status, status),
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

}  // namespace odomd::tools
