// Shared by tests of the tools: running programs in a directory of their own, and what they answer.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/gtest.hpp"
#include "tests/scratch.hpp"
#include "tests/table.hpp"

namespace odomd::tools {

using odomd::contents;
using odomd::message_of;

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
  const odomd::Scratch scratch;
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

/// A directory in which commands run, so that they name its files without a path.
class Scratch : public odomd::Scratch {
 public:
  [[nodiscard]] Outcome run(const std::string& command) const {
    return run_shell("cd " + path("").string() + " && " + command);
  }
  /// The standard output of a command line, which must succeed.
  std::string must_run(const std::string& command) const {
    return tools::must_run("cd " + path("").string() + " && " + command);
  }
  /// The document on the standard output of a command line.
  [[nodiscard]] nlohmann::json json(const std::string& command) const {
    const Outcome outcome = run(command);
    EXPECT_TRUE(nlohmann::json::accept(outcome.out)) << command << ": " << outcome.err;
    return nlohmann::json::parse(outcome.out, nullptr, false);
  }
  [[nodiscard]] std::string text(std::string_view name) const { return contents(path(name)); }
};

/// The first error of a text parsed as XML (our pages and pictures are); empty if none.
inline std::string markup_fault(std::string_view text) {
  const Scratch scratch;
  scratch.write("page", text);
  return scratch
      .run("python3 -c 'import xml.etree.ElementTree as xml; xml.parse(\"page\")' 2>&1 | tail -n 1")
      .out;
}

/// Matches a JSON object that has these members, perhaps among others.
MATCHER_P(Includes, members, std::string{"includes "} + members) {
  nlohmann::json patched = arg;
  patched.merge_patch(nlohmann::json::parse(members));
  return patched == arg;
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

/// The estimate of odom evaluate for a replay with these options, compared with a reference.
inline nlohmann::json errors_of_replay(const Scratch& scratch, const std::string& options,
                                       const std::string& reference) {
  scratch.must_run("odom replay " + options + " --out replayed.csv");
  return scratch.json("odom evaluate --json --pose replayed.csv --reference " + reference)
      .at("estimates")
      .at(0);
}

/// A simulated drive in a directory of its own, for all tests of a suite.
struct SharedDrive {
  explicit SharedDrive(const std::string& options, std::string_view name = "drive")
      : folder(simulate(scratch, options, name)) {}
  /// Runs a command in the drive's folder.
  [[nodiscard]] Outcome run(const std::string& command) const {
    return run_shell("cd " + folder.string() + " && " + command);
  }
  Scratch scratch;
  std::filesystem::path folder;
};

/// Runs `command` with the left part of each row of a table, in the directory. It must end with
/// this status. Standard error must contain the right part, or equal it if that begins with "odom".
/// With status 2 it is one line, and standard output is empty.
inline void expect_answers(const Scratch& scratch, int status, const std::string& command,
                           const char* table) {
  for_each_row(table, [&](const std::string& arguments, const std::string& says) {
    const Outcome outcome = scratch.run(command + ' ' + arguments);
    EXPECT_EQ(outcome.status, status) << arguments << ": " << outcome.err;
    if (says.starts_with("odom"))
      EXPECT_EQ(outcome.err, says + '\n') << arguments;
    else
      EXPECT_THAT(outcome.err, HasSubstr(says)) << arguments;
    if (status != 2) return;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << arguments << ": " << outcome.err;
  });
}

}  // namespace odomd::tools
