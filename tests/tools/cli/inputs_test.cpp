// Every command refuses inputs that are not text files, at once and with the fix.
#include "tests/tools/scratch.hpp"

namespace odomd::tools::inputs_test {
namespace {

class Inputs : public ::testing::Test {
 protected:
  static std::string folder() {
    static const SharedDrive made{"--scenario circle --laps 1", "d"};
    static const Outcome more = run_shell("cd " + made.scratch.path("").string() +
                                          " && mkfifo pipe && ln -s /dev/zero zero && "
                                          "cp -r d piped && rm piped/drive.log && "
                                          "mkfifo piped/drive.log && "
                                          "gzip -k d/car.toml d/car.dbc d/camera.csv");
    EXPECT_EQ(more.status, 0) << more.err;
    return made.scratch.path("").string();
  }
  /// The error of a command line in the folder; it must end within ten seconds.
  static std::string refused(const std::string& line) {
    const Outcome outcome = run_shell("cd " + folder() + " && timeout 10 " + line);
    EXPECT_EQ(outcome.status, 2) << line << ": " << outcome.err;
    return outcome.err;
  }
};

TEST_F(Inputs, APipeOrADeviceIsRefusedWhereverAFileIsRead) {
  for (const auto& [input, kind] : {std::pair{"pipe", "pipe: is a named pipe; name a file"},
                                    std::pair{"zero", "zero: is a device; name a file"}})
    for (const std::string& line : std::vector<std::string>{
             "odom replay --can d/drive.log --out o --config ",
             "odom replay --can d/drive.log --out o --config d/car.toml --dbc ",
             "odom replay --can d/drive.log --out o --config d/car.toml --camera ",
             "odom evaluate --reference d/truth.csv --pose ",
             "odom evaluate --pose d/truth.csv --reference ", "odom evaluate --drive d --config ",
             "odom plot --out o.svg ", "odom export --mcap o.mcap ", "odom doctor --config ",
             "odom dbc show ", "odom camera send --log ", "odom identify noise --csv ",
             "odom init --can d/drive.log --out o.toml --dbc ", "odomd --check --config "})
      EXPECT_THAT(refused(line + input), HasSubstr(kind)) << line;
}

TEST_F(Inputs, ADriveWhoseLogIsAPipeIsRefused) {
  for (const char* line : {"odom evaluate --drive piped", "odom doctor --drive piped",
                           "odom replay --out o --drive piped", "odom export --csv o piped"})
    EXPECT_THAT(refused(line), HasSubstr("piped/drive.log: is a named pipe, not a file"));
}

TEST_F(Inputs, APipeOfTheShellIsRead) {
  must_run("cd " + folder() +
           " && bash -c 'timeout 60 odom replay --can d/drive.log "
           "--config d/car.toml --dbc <(cat d/car.dbc) --camera <(cat d/camera.csv) "
           "--out o'");
}

TEST_F(Inputs, WhatIsPackedIsNamedWithTheCommandThatUnpacksIt) {
  for (const std::string& line : std::vector<std::string>{
           "odomd --check --config d/car.toml",
           "odom replay --config d/car.toml --can d/drive.log --out o --dbc d/car.dbc",
           "odom replay --config d/car.toml --can d/drive.log --out o --camera d/camera.csv"})
    EXPECT_THAT(refused(line + ".gz"), HasSubstr(".gz: is packed; unpack it: gunzip -k d/"));
}

TEST_F(Inputs, ALogInReverseIsNamed) {
  EXPECT_THAT(run_shell("cd " + folder() +
                        " && tac d/drive.log > reverse.log && odom replay "
                        "--config d/car.toml --can reverse.log --out o")
                  .err,
              HasSubstr("the log is in reverse, which tac undoes: "));
}

TEST_F(Inputs, EmptyValuesAreRefused) {
  for (const char* line : {"odom pose --shm ''", "odom status --socket ''", "odom export ''",
                           "odom replay --drive d --out o --camera ''"})
    EXPECT_THAT(refused(line), HasSubstr(": is empty; give a value, or leave it out")) << line;
}

TEST_F(Inputs, NumbersWithUnitsOrDecimalCommasAreNamed) {
  EXPECT_THAT(refused("odom camera send --pose 1,2,90deg"),
              AllOf(HasSubstr("--pose = 1,2,90deg"), HasSubstr("without a unit")));
}

TEST_F(Inputs, DrivesAreTakenWithAndWithoutTheirOption) {
  const auto out = [](const std::string& line) {
    const Outcome outcome = run_shell("cd " + folder() + " && " + line);
    EXPECT_LE(outcome.status, 1) << line << ": " << outcome.err;
    return outcome.out;
  };
  EXPECT_NE(out("odom replay --drive d --out -"), "");
  for (const auto& [before, after] : {std::pair{"odom replay --out - ", ""},
                                      {"odom doctor ", ""},
                                      {"odom evaluate --model kinematic ", ""},
                                      {"odom export --csv - ", ""}})
    EXPECT_EQ(out(before + std::string("--drive d") + after),
              out(before + std::string("d") + after));
  EXPECT_THAT(refused("odom evaluate nowhere"), HasSubstr("nowhere: is not a folder"));
  EXPECT_THAT(refused("odom replay --out - nowhere"), HasSubstr("nowhere: is not a folder"));
}

TEST_F(Inputs, ADriveIsReplayedLikeItsFiles) {
  const auto replayed = [](const std::string& options) {
    return must_run("cd " + folder() + " && odom replay --out - " + options);
  };
  const std::string whole = replayed("--config d/car.toml --can d/drive.log --camera d/camera.csv");
  EXPECT_EQ(replayed("--drive d"), whole);
  EXPECT_EQ(replayed("--drive d --config d/car.toml"), whole);
  EXPECT_NE(replayed("--drive d --model kinematic"), whole);
  EXPECT_THAT(refused("odom replay --drive d --recording d --out o"), HasSubstr("excludes"));
}

}  // namespace
}  // namespace odomd::tools::inputs_test
