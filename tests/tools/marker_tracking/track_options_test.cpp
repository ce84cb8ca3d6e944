// The command line of odom identify track, which exists even without OpenCV.
#include "tools/marker_tracking/options.hpp"

#include <CLI/CLI.hpp>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::track_options_test {
namespace {

TrackOptions parsed(const std::vector<std::string>& arguments) {
  CLI::App app;
  TrackOptions options;
  describe_track(Command(app), options);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  app.parse(reversed);
  return options;
}

std::string refusal(const std::vector<std::string>& arguments) {
  return message_of([&] { check(parsed(arguments)); });
}

TEST(TrackOptions, AreParsed) {
  const TrackOptions options =
      parsed({"film.mp4", "--out=a.csv", "--aruco=4x4_50", "--front=7", "--rear=8",
              "--lens=lens.yaml", "--ground-marker=1=3,-4", "--ground-marker=2=3,4",
              "--height=0.125", "--ground-marker=3=4,4", "--ground-marker=4=3,6", "--fps=240"});
  EXPECT_EQ(options.height, 0.125);
  EXPECT_EQ(options.ground_markers.size(), 4U);
}

TEST(TrackOptions, ContradictionsAreRefused) {
  using Arguments = std::vector<std::string>;
  const std::pair<Arguments, const char*> whole[]{
      {{}, "--aruco 4x4_50"},
      {{"--aruco=4x4_50", "--front=7"}, "--rear ID"},
      {{"--aruco=4x4_50", "--front=7", "--rear=7"}, "different"},
      {{"--calibrate=9x6"}, "--square"},
      {{"--calibrate=9", "--square=0.1", "--out=l.yaml"}, "COLUMNSxROWS"},
      {{"--calibrate=9x2", "--square=0.1", "--out=l.yaml"}, "COLUMNSxROWS"},
      {{"--calibrate=9x6", "--square=0.1"}, "--out lens.yaml"},
  };
  const auto refusal_of = [](Arguments arguments) {
    arguments.insert(arguments.begin(), "f.mp4");
    return refusal(arguments);
  };
  for (const auto& [arguments, says] : whole) EXPECT_THAT(refusal_of(arguments), HasSubstr(says));
  EXPECT_EQ(refusal_of({"--aruco=4x4_50", "--front=7", "--rear=8"}), "");
  const std::pair<Arguments, const char*> added[]{
      {{"--ground-marker=1=3,4"}, "at least four"},
      {{"--ground-marker=1=3"}, "ID=X,Y"},
      {{"--ground-marker=1=3,4,5"}, "ID=X,Y"},
      {{"--ground-marker=x=3,4", "--ground-marker=1=3,4", "--ground-marker=2=3,4",
        "--ground-marker=3=3,4"},
       "ID=X,Y"},
      {{"--height=0.1"}, "--lens"},
      {{"--fps=0"}, "--fps"},
      {{"--out=f.mp4"}, "--out: f.mp4 is what is read"},
      {{"--lens=l.yaml", "--out=l.yaml"}, "--out: l.yaml is what is read"}};
  for (auto [arguments, says] : added) {
    arguments.insert(arguments.end(), {"--aruco=4x4_50", "--front=7", "--rear=8"});
    EXPECT_THAT(refusal_of(arguments), HasSubstr(says));
  }
}

}  // namespace
}  // namespace odomd::tools::track_options_test
