// What each command says of a log that is out of order, or lacks what it needs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::log_faults_test {
namespace {

using testing::HasSubstr;

/// What the commands say of a simulated drive whose log `change` has made into another.
void expect_named(const std::string& change, const std::string& reason,
                  const std::vector<std::string>& commands) {
  const Scratch scratch;
  const Outcome made = run_shell(
      "cd " + scratch.path("").string() +
      " && odom sim --scenario circles --markers --duration 20 --seed 3 --out lap && cd lap && " +
      change + " && mv new.log drive.log");
  EXPECT_EQ(made.status, 0) << made.err;
  for (const std::string& command : commands)
    expect_refused("cd " + scratch.path("lap").string() + " && ", {{command, HasSubstr(reason)}});
}

const std::string stiffness =
    "odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 --y-down "
    "--run markers.csv,drive.log";
const std::string latency = "odom identify latency --config car.toml --can drive.log";
const std::string noise = "odom identify noise --config car.toml --can drive.log";
const std::string inertia =
    "odom identify inertia --config car.toml --can drive.log --mass 2.985 --spacing 0.2 --cord 1";

TEST(LogFaults, AreNamedByEveryCommand) {
  expect_named(
      "n=$(($(wc -l <drive.log) / 2)) && "
      "(tail -n +$((n + 1)) drive.log; head -n $n drive.log) >new.log",
      "sort the log",
      {stiffness, latency, noise, inertia, "odom identify noise --drive .",
       "odom evaluate --drive ."});
  expect_named("tac drive.log >new.log", "(tac turns one in reverse)",
               {latency, noise, "odom evaluate --drive ."});
  expect_named("grep -v ' 1A2#' drive.log >new.log", "no frame of it is in the log",  // the IMU
               {stiffness, latency, inertia});
}

}  // namespace
}  // namespace odomd::tools::log_faults_test
