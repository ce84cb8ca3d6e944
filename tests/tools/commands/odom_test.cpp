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

constexpr auto millimetres = "[W401]";
constexpr auto degrees = "[W403]";

// A simulated drive; its camera log and truth in other units are next to it.
class Units : public ::testing::Test {
 protected:
  Units() {
    const std::string scale =
        "; awk -F, -v OFS=, -v CONVFMT=%.9g 'NR > 1 { $c *= m; $(c + 1) *= m; $(c + 2) *= r } 1' ";
    must_run("cd " + scratch_.path("").string() +
             " && odom sim --scenario lap --duration 20 --out drive && cd drive || exit 1" + scale +
             "c=3 m=1000 r=1 camera.csv >camera_mm.csv" +  //
             scale + "c=3 m=1 r=57.29578 camera.csv >camera_deg.csv" + scale +
             "c=2 m=1000 r=1 truth.csv >truth_mm.csv" + scale +
             "c=2 m=1 r=57.29578 truth.csv >truth_deg.csv");
  }

  [[nodiscard]] std::string said(const std::string& command) const {
    const Outcome outcome = run_shell("cd " + scratch_.path("drive").string() + " && " + command);
    return outcome.err;
  }
  [[nodiscard]] std::string replayed_with(const std::string& camera) const {
    return said("odom replay --config car.toml --can drive.log --out pose.csv --camera " + camera);
  }

  Scratch scratch_;
};

TEST_F(Units, OfACameraAreReportedByReplay) {
  EXPECT_THAT(replayed_with("camera.csv"), Not(HasSubstr("warning")));
  EXPECT_THAT(replayed_with("camera_mm.csv"),
              AllOf(HasSubstr("warning: camera: x and y go about 1000 times as far as the wheels"),
                    HasSubstr(millimetres), Not(HasSubstr("scale")), Not(HasSubstr("gated")),
                    Not(HasSubstr("another drive"))));
  EXPECT_THAT(replayed_with("camera_deg.csv"),
              AllOf(HasSubstr("warning: camera: yaw turns about 57 times as far as the gyro"),
                    HasSubstr(degrees), Not(HasSubstr("mounting"))));
}

TEST_F(Units, OfAReferenceAndAPoseFileAreReportedByEvaluate) {
  static_cast<void>(replayed_with("camera.csv"));
  const std::string evaluate = "odom evaluate --pose pose.csv --reference ";
  EXPECT_THAT(said(evaluate + "truth.csv"), Not(HasSubstr("warning")));
  EXPECT_THAT(said(evaluate + "truth_mm.csv"),
              AllOf(HasSubstr("truth_mm.csv: x and y go about 1000 times as far as the estimate"),
                    HasSubstr(millimetres), Not(HasSubstr("jumps"))));
  EXPECT_THAT(said(evaluate + "truth_mm.csv --fit-lever-arm"),
              AllOf(HasSubstr(millimetres), Not(HasSubstr("too differently"))));
  EXPECT_THAT(
      said(evaluate + "truth_deg.csv"),
      AllOf(HasSubstr("truth_deg.csv: yaw turns about 57 times as far as the estimate"),
            HasSubstr(degrees), Not(HasSubstr("do not follow")), Not(HasSubstr("disagree with"))));
  EXPECT_THAT(said("odom evaluate --reference truth.csv --pose truth.csv --pose truth_mm.csv"),
              AllOf(HasSubstr("truth_mm.csv: x and y go about 1000 times as far as the reference"),
                    Not(HasSubstr("stays at one place"))));
}

TEST_F(Units, OfADriveAreReportedOnce) {
  EXPECT_THAT(said("odom evaluate --drive . --model kinematic --reference truth_mm.csv"),
              AllOf(HasSubstr("drive: truth_mm.csv: x and y go about 1000 times"),
                    Not(HasSubstr("jumps"))));
  const std::string both =
      said("cp camera_mm.csv camera.csv; cp truth_deg.csv truth.csv; odom evaluate --drive .");
  EXPECT_THAT(both, AllOf(HasSubstr("drive: camera: x and y go about 1000 times"),
                          HasSubstr("drive: ./truth.csv: yaw turns about 57 times"),
                          Not(HasSubstr("another drive"))));
  // Without the camera, the gyro's bias is not learnt either.
  EXPECT_EQ(std::ranges::count(both, '\n'), 3) << both;
}

}  // namespace
}  // namespace odomd::tools::odom_test
