// Shared by tests of the tools: running a program in a directory of its own.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>

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

/// Matches an outcome with this exit status and a standard error that equals or matches `err`.
inline ::testing::Matcher<const Outcome&> Ends(int status,
                                               const ::testing::Matcher<std::string>& err) {
  return AllOf(::testing::Field("status", &Outcome::status, status),
               ::testing::Field("err", &Outcome::err, err));
}

/// Runs a shell command line in which `odom` is the built program.
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

/// The standard output of a command line, which must succeed.
inline std::string must_run(const std::string& command) {
  const Outcome outcome = run_shell(command);
  EXPECT_EQ(outcome.status, 0) << command << ": " << outcome.err;
  return outcome.out;
}

/// Runs `odom sim` with these options; returns the drive's folder in the directory. Throws if it
/// fails.
inline std::string simulate(const Scratch& scratch, const std::string& options,
                            std::string_view name = "drive") {
  std::string folder = scratch.path(name).string();
  const Outcome outcome = run_shell("odom sim " + options + " --out " + folder);
  if (outcome.status != 0) throw std::runtime_error("odom sim: " + outcome.err);
  return folder;
}

/// A simulated drive in a directory of its own, for all tests of a suite.
struct SharedDrive {
  explicit SharedDrive(const std::string& options, std::string_view name = "drive")
      : folder(simulate(scratch, options, name)) {}
  Scratch scratch;
  std::filesystem::path folder;
};

/// Runs each of the lines after `before`. Each must be refused: status 2, nothing on standard
/// output, and on standard error one line that equals or matches the given text.
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
