// The command line of odom identify track, which is there without OpenCV too.
#include "tools/marker_tracking/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::track_options_test {
namespace {

using testing::HasSubstr;

TrackOptions parsed(const std::vector<std::string>& arguments,
                    std::vector<std::string>* handed_over = nullptr) {
  CLI::App app;
  TrackOptions options;
  describe_track(Command(app), options);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  app.parse(reversed);
  if (handed_over != nullptr) *handed_over = Command(app).given();
  return options;
}

std::string refusal(const std::vector<std::string>& arguments) {
  try {
    check(parsed(arguments));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

TEST(TrackOptions, GoToTheOtherProgramAsTheyCame) {
  const std::vector<std::string> given{
      "film.mp4",           "--out=a.csv",      "--aruco=4x4_50",    "--front=7",
      "--rear=8",           "--lens=lens.yaml", "--ground=1,2=3,-4", "--ground=1,3=3,4",
      "--ground=2,2=0.5,4", "--ground=5,2=3,6", "--height=0.125",    "--fps=240",
      "--progress"};
  std::vector<std::string> handed_over, again;
  EXPECT_EQ(parsed(given, &handed_over).height, 0.125);
  EXPECT_EQ(parsed(handed_over, &again).ground.size(), 4U);
  std::ranges::sort(handed_over);
  std::ranges::sort(again);
  std::vector<std::string> sorted = given;
  std::ranges::sort(sorted);
  EXPECT_EQ(handed_over, sorted);
  EXPECT_EQ(again, sorted);
}

TEST(TrackOptions, WhatDoesNotHangTogetherIsRefused) {
  EXPECT_THAT(refusal({"f.mp4"}), HasSubstr("one kind of marker"));
  EXPECT_THAT(refusal({"f.mp4", "--aruco=4x4_50", "--front=7"}), HasSubstr("--rear ID"));
  EXPECT_THAT(refusal({"f.mp4", "--aruco=4x4_50", "--front=7", "--rear=7"}),
              HasSubstr("different"));
  EXPECT_THAT(refusal({"f.mp4", "--colour-front=120,40,30"}), HasSubstr("both are needed"));
  EXPECT_THAT(refusal({"f.mp4", "--colour-front=120,40,30", "--colour-rear=400,1,1"}),
              HasSubstr("HUE,SATURATION,BRIGHTNESS"));
  const std::vector<std::string> good{"f.mp4", "--aruco=4x4_50", "--front=7", "--rear=8"};
  EXPECT_EQ(refusal(good), "taken");
  const auto with = [&good](const std::vector<std::string>& more) {
    std::vector<std::string> all = good;
    all.insert(all.end(), more.begin(), more.end());
    return refusal(all);
  };
  EXPECT_THAT(with({"--ground=1,2=3,4"}), HasSubstr("four places"));
  EXPECT_THAT(with({"--ground=1,2=3", "--ground=1,2=3,4", "--ground=1,2=3,4", "--ground=1,2=3,4"}),
              HasSubstr("U,V=X,Y"));
  EXPECT_THAT(with({"--ground-marker=x=3,4", "--ground-marker=1=3,4", "--ground-marker=2=3,4",
                    "--ground-marker=3=3,4"}),
              HasSubstr("ID=X,Y"));
  EXPECT_THAT(with({"--height=0.1"}), HasSubstr("--lens"));
  EXPECT_THAT(with({"--fps=0"}), HasSubstr("--fps"));
  EXPECT_THAT(with({"--out=f.mp4"}), HasSubstr("--out: f.mp4 is what is read"));
  EXPECT_THAT(with({"--lens=l.yaml", "--out=l.yaml"}), HasSubstr("--out: l.yaml is what is read"));
  EXPECT_THAT(refusal({"f.mp4", "--calibrate=9x6"}), HasSubstr("--square"));
  EXPECT_THAT(refusal({"f.mp4", "--calibrate=9", "--square=0.1", "--out=l.yaml"}),
              HasSubstr("COLUMNSxROWS"));
}

TEST(TrackOptions, WithoutItsProgramTheCommandSaysWhatToInstall) {
  const Scratch scratch;
  std::filesystem::copy_file(ODOMD_BIN_DIR "/odom", scratch.path("odom"));
  const Outcome outcome = run_shell(scratch.path("odom").string() +
                                    " identify track f.mp4 --aruco 4x4_50 --front 1 --rear 2");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("libopencv-dev"));
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1);
}

}  // namespace
}  // namespace odomd::tools::track_options_test
