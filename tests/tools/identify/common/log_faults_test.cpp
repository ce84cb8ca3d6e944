// What each command says of a log that is out of order, or lacks what it needs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::log_faults_test {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

/// A drive whose log is `log` of that of a simulated one.
class Drive {
 public:
  explicit Drive(const std::string& log) {
    const Outcome made = run_shell(
        "cd " + scratch_.path("").string() +
        " && odom sim --scenario circles --markers --duration 20 --seed 3 --out lap && cd lap && " +
        log + " && mv new.log drive.log");
    EXPECT_EQ(made.status, 0) << made.err;
  }

  void expect(const std::string& command, const std::string& reason) const {
    const Outcome outcome = run_shell("cd " + scratch_.path("lap").string() + " && " + command);
    EXPECT_EQ(outcome.status, 2) << command;
    EXPECT_EQ(outcome.out, "") << command;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr(reason), EndsWith("\n"))) << command;
    EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << command << ": " << outcome.err;
  }

 private:
  Scratch scratch_;
};

const std::string stiffness =
    "odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 --y-down "
    "--run markers.csv,drive.log";
const std::string latency = "odom identify latency --config car.toml --can drive.log";
const std::string noise = "odom identify noise --config car.toml --can drive.log";
const std::string inertia =
    "odom identify inertia --config car.toml --can drive.log --mass 2.985 --spacing 0.2 --cord 1";

TEST(LogFaults, TimesThatRunBackwardsAreNamedByEveryCommand) {
  const Drive drive(
      "n=$(($(wc -l <drive.log) / 2)) && "
      "(tail -n +$((n + 1)) drive.log; head -n $n drive.log) >new.log");
  for (const std::string& command :
       {stiffness, latency, noise, inertia, std::string{"odom identify noise --drive ."},
        std::string{"odom evaluate --drive ."}})
    drive.expect(command, "sort the log");
}

TEST(LogFaults, ALogInReverseIsToBeTurned) {
  const Drive drive("tac drive.log >new.log");
  for (const std::string& command : {latency, noise, std::string{"odom evaluate --drive ."}})
    drive.expect(command, "(tac turns one in reverse)");
}

TEST(LogFaults, AMissingMessageIsNamedWithItsLog) {
  const Drive drive("grep -v ' 1A2#' drive.log >new.log");  // the IMU
  for (const std::string& command : {stiffness, latency, inertia})
    drive.expect(command, "no frame of it is in the log");
}

}  // namespace
}  // namespace odomd::tools::log_faults_test
