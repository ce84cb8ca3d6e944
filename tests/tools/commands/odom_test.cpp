// The command line of odom as a whole, and units in its arguments.
#include "tests/tools/scratch.hpp"

namespace odomd::tools::odom_test {
namespace {

TEST(Odom, PrintsItsVersion) {
  EXPECT_THAT(must_run("odom --version"), StartsWith("odom "));
}

TEST(Odom, WrongUsageIsOneLineAndStatusTwo) {
  for (const char* line : {"odom", "odom nonsense", "odom --nonsense", "odom nonsense --help"})
    expect_refused("", {{line, AllOf(StartsWith("odom: "), HasSubstr("see odom --help"))}});
}

TEST(Odom, AFullDiskIsFailedWork) {
  EXPECT_THAT(run_shell("odom --help >/dev/full"),
              Ends(1, "odom: standard output: No space left on device\n"));
}

// odom looks for its companion programs next to itself.
TEST(Odom, SaysWhatToInstallWhereACompanionIsMissing) {
  const Scratch scratch;
  std::filesystem::copy_file(ODOMD_BIN_DIR "/odom", scratch.path("odom"));
  for (const auto& [command, package] :
       {std::pair{" serve", "install the package odom-web"},
        {" bridge", "install the package odom-bridge"},
        {" identify track f.mp4 --aruco 4x4_50 --front 1 --rear 2", "libopencv-dev"},
        {" identify fit --drive somewhere",
         "odom identify fit: fitting needs odom-fit: install the package odom-fit; or install "
         "libceres-dev, and configure and build all: cmake --preset release && cmake --build "
         "--preset release\n"}}) {
    const Outcome outcome = run_shell(scratch.path("odom").string() + command);
    EXPECT_THAT(outcome, Ends(1, HasSubstr(package))) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  }
}

// A simulated drive with its camera log and truth in other units: each is reported once, without
// the findings that follow from it.
TEST(Units, OfPosesAreReportedByReplayAndEvaluate) {
  const Scratch scratch;
  const std::string in_drive = "cd " + scratch.path("drive").string() + " && ";
  const std::string scale =
      "; awk -F, -v OFS=, -v CONVFMT=%.9g 'NR > 1 { $c *= m; $(c + 1) *= m; $(c + 2) *= r } 1' ";
  must_run("cd " + scratch.path("").string() +
           " && odom sim --scenario lap --duration 20 --out drive && " + in_drive + ":" + scale +
           "c=3 m=1000 r=1 camera.csv >camera_mm.csv" + scale +
           "c=3 m=1 r=57.29578 camera.csv >camera_deg.csv" + scale +
           "c=2 m=1000 r=1 truth.csv >truth_mm.csv" + scale +
           "c=2 m=1 r=57.29578 truth.csv >truth_deg.csv");
  const char* const replay =
      "odom replay --config car.toml --can drive.log --out pose.csv --camera ";
  const char* const evaluate = "odom evaluate --pose pose.csv --reference ";
  using Texts = std::vector<const char*>;
  const struct {
    std::string command;
    Texts says;
    Texts not_then;
  } cases[]{
      {std::string(replay) + "camera_mm.csv",
       {"warning: camera: x and y go about 1000 times as far as the wheels", "[W401]"},
       {"scale", "gated", "another drive"}},
      {std::string(replay) + "camera_deg.csv",
       {"warning: camera: yaw turns about 57 times as far as the gyro", "[W403]"},
       {"mounting"}},
      {std::string(replay) + "camera.csv", {}, {"warning"}},
      {std::string(evaluate) + "truth.csv", {}, {"warning"}},
      {std::string(evaluate) + "truth_mm.csv",
       {"truth_mm.csv: x and y go about 1000 times as far as the estimate", "[W401]"},
       {"jumps"}},
      {std::string(evaluate) + "truth_mm.csv --fit-lever-arm", {"[W401]"}, {"too differently"}},
      {std::string(evaluate) + "truth_deg.csv",
       {"truth_deg.csv: yaw turns about 57 times as far as the estimate", "[W403]"},
       {"do not follow", "disagree with"}},
      {"odom evaluate --reference truth.csv --pose truth.csv --pose truth_mm.csv",
       {"truth_mm.csv: x and y go about 1000 times as far as the reference"},
       {"stays at one place"}},
      {"odom evaluate --drive . --model kinematic --reference truth_mm.csv",
       {"drive: truth_mm.csv: x and y go about 1000 times"},
       {"jumps"}},
      {"cp camera_mm.csv camera.csv; cp truth_deg.csv truth.csv; odom evaluate --drive .",
       {"drive: camera: x and y go about 1000 times",
        "drive: ./truth.csv: yaw turns about 57 times"},
       {"another drive"}}};
  std::string err;
  for (const auto& [command, says, not_then] : cases) {
    err = run_shell(in_drive + command).err;
    for (const char* text : says) EXPECT_THAT(err, HasSubstr(text)) << command;
    for (const char* text : not_then) EXPECT_THAT(err, Not(HasSubstr(text))) << command;
  }
  // Without the camera, the gyro's bias is not learnt either.
  EXPECT_EQ(std::ranges::count(err, '\n'), 3) << err;
}

}  // namespace
}  // namespace odomd::tools::odom_test
