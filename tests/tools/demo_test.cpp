// Tests tools/demo.sh without driving, building or downloading anything.
#include "tests/tools/scratch.hpp"

namespace odomd::tools::demo_test {
namespace {

// A source tree with the demonstration, in which everything is built and an earlier run's output
// exists.
class Demo : public ::testing::Test {
 protected:
  Demo() {
    for (const char* folder : {"tools", "stubs", "build/release", "build/demo"})
      std::filesystem::create_directories(scratch_.path(folder));
    std::filesystem::copy_file(ODOMD_DEMO, scratch_.path("tools/demo.sh"));
    for (const char* program : {"tools/dependencies.sh", "stubs/cmake"})
      std::filesystem::permissions(scratch_.write(program, "#!/bin/sh\n"),
                                   std::filesystem::perms::owner_all);
    std::filesystem::create_directory_symlink(ODOMD_BIN_DIR, scratch_.path("build/release/bin"));
    scratch_.write("build/demo/evaluation.txt", "an earlier one");
  }

  [[nodiscard]] Outcome run(const std::string& arguments, const std::string& more = "") const {
    return run_shell("PATH=" + scratch_.path("stubs").string() + ":$PATH ODOMD_DEMO_ARGUMENTS='" +
                     arguments + "' timeout 60 bash " + scratch_.path("tools/demo.sh").string() +
                     more);
  }
  [[nodiscard]] std::string earlier() const { return scratch_.text("build/demo/evaluation.txt"); }

 private:
  Scratch scratch_;
};

TEST_F(Demo, KeepsAnEarlierOutputWhereAnOptionIsWrong) {
  for (const std::string wrong : {"--scenari lap", "--laps none", "--can drive.log",
                                  "--scenario nowhere", "--json", "--help", "--list"}) {
    const Outcome outcome = run(wrong);
    EXPECT_THAT(outcome, Ends(2, HasSubstr("demo: fix ODOMD_DEMO_ARGUMENTS='" + wrong)));
    if (wrong != "--help" && wrong != "--list") {
      EXPECT_THAT(outcome.err, HasSubstr("odom sim: "));
    }
    EXPECT_EQ(earlier(), "an earlier one") << wrong;
  }
}

TEST_F(Demo, SaysWhereOptionsGo) {
  EXPECT_THAT(run("", " --laps 3"), Ends(2,
                                         "demo: takes no arguments; for odom sim: "
                                         "ODOMD_DEMO_ARGUMENTS='--laps 3' bash tools/demo.sh\n"));
}

}  // namespace
}  // namespace odomd::tools::demo_test
