// What is misspelt on a command line is named, the first of it, with what was likely meant.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::misspelt_test {
namespace {

// What is said, without its newline.
std::string refused(const std::string& line) {
  const Outcome outcome = run_shell(line);
  EXPECT_EQ(outcome.status, 2) << line;
  EXPECT_EQ(outcome.out, "") << line;
  EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  return outcome.err.substr(0, outcome.err.find('\n'));
}

TEST(Misspelt, AnOptionIsNamedWithTheOneThatWasMeant) {
  EXPECT_EQ(refused("odom sim --scenari lap"),
            "odom sim: unknown option \"--scenari\" (did you mean \"--scenario\"?); see odom sim "
            "--help");
  EXPECT_EQ(refused("odom sim --scenario=lap --lpas=3"),
            "odom sim: unknown option \"--lpas\" (did you mean \"--laps\"?); see odom sim --help");
  EXPECT_EQ(refused("odom replay --ot x --config c"),
            "odom replay: unknown option \"--ot\" (did you mean \"--out\"?); see odom replay "
            "--help");
  EXPECT_EQ(refused("odom sim -laps 3"),
            "odom sim: unknown option \"-laps\" (did you mean \"--laps\"?); see odom sim --help");
  EXPECT_EQ(refused("odom watch --nonsense"),
            "odom watch: unknown option \"--nonsense\"; see odom watch --help");
}

TEST(Misspelt, AnUnknownCommandHasNoHelp) {
  EXPECT_EQ(refused("odom dbc shwo --help"),
            "odom dbc: no command \"shwo\" (did you mean \"show\"?); see odom dbc --help");
}

TEST(Misspelt, TheFirstArgumentIsReportedFirst) {
  EXPECT_EQ(refused("odom evaluate --refrence x --poes y"),
            "odom evaluate: unknown option \"--refrence\" (did you mean \"--reference\"?); see "
            "odom evaluate --help");
  EXPECT_EQ(refused("odom evaluate a b c"), "odom evaluate: a: is not a folder; check the path");
  EXPECT_EQ(refused("odom watch status"),
            "odom watch: unexpected argument \"status\"; see odom watch --help");
}

TEST(Misspelt, AnOptionComesBeforeTheOneThatIsMissingForIt) {
  EXPECT_EQ(refused("odom plot pose.csv --otu x.png"),
            "odom plot: unknown option \"--otu\" (did you mean \"--out\"?); see odom plot --help");
  EXPECT_EQ(refused("odomd --confg car.toml --cna can0"),
            "odomd: unknown option \"--confg\" (did you mean \"--config\"?); see odomd --help");
  EXPECT_EQ(refused("odomd start"), "odomd: unexpected argument \"start\"; see odomd --help");
  EXPECT_EQ(refused("odomd"), "odomd: --config is required; see odomd --help");
}

TEST(Misspelt, AnOptionBeforeItsCommandIsSentThere) {
  EXPECT_EQ(refused("odom --lasp"),
            "odom: unknown option \"--lasp\" (did you mean \"odom sim --laps\"?); see odom --help");
  EXPECT_EQ(refused("odom --config car.toml replay"),
            "odom: unknown option \"--config\" (did you mean \"odom replay --config\"?); see odom "
            "--help");
  EXPECT_EQ(refused("odom --config car.toml"),
            "odom: unknown option \"--config\": options go after the command that has them; "
            "see odom --help");
  EXPECT_EQ(refused("odom camera --foo send"),
            "odom camera: unknown option \"--foo\"; see odom camera --help");
}

TEST(Misspelt, ACommandIsNamedWithTheOneThatWasMeant) {
  EXPECT_EQ(refused("odom evalute --pose x"),
            "odom: no command \"evalute\" (did you mean \"evaluate\"?); see odom --help");
  EXPECT_EQ(refused("odom identify ltency"),
            "odom identify: no command \"ltency\" (did you mean \"latency\"?); see odom identify "
            "--help");
  EXPECT_EQ(refused("odom help wtach"),
            "odom help: no command \"wtach\" (did you mean \"watch\"?)");
  EXPECT_EQ(refused("odom dbc nonsense"),
            "odom dbc: no command \"nonsense\"; there are: show, decode; see odom dbc --help");
  EXPECT_EQ(refused("odom dbc"),
            "odom dbc: no command given; there are: show, decode; see odom dbc --help");
}

TEST(Misspelt, OptionsOfTheCompanionProgramsAreReported) {
  EXPECT_EQ(refused("odom identify fit --confg car.toml --drvie x"),
            "odom identify fit: unknown option \"--confg\" (did you mean \"--config\"?); see odom "
            "identify fit --help");
  EXPECT_EQ(refused("odom identify track film.mp4 --mraker x"),
            "odom identify track: unknown option \"--mraker\"; see odom identify track --help");
}

}  // namespace
}  // namespace odomd::tools::misspelt_test
