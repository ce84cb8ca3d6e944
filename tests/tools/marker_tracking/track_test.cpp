// odom identify track on rendered films of a known motion.
#include "tools/marker_tracking/film.hpp"

#include <functional>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "tests/tools/scratch.hpp"
#include "tools/identify/stiffness/film.hpp"
#include "tools/marker_tracking/film_renderer.hpp"

namespace odomd::tools::track_test {
namespace {

constexpr double car_height = 0.1;
constexpr double side = 0.16;
constexpr int frames = 40;
constexpr double rate = 50.0;

struct Pose {
  double x = 0.0, y = 0.0, yaw = 0.0;
};

// A circle of 0.7 m radius, driven for 1.25 turns.
Pose pose_at(int frame) {
  const double angle = 2.5 * 3.141592653589793 * frame / frames;
  return {0.7 * std::cos(angle), 0.7 * std::sin(angle), angle + 1.6};
}

Plane at_body(const Pose& pose, Plane place) {
  return Plane{pose.x, pose.y} + std::polar(1.0, pose.yaw) * place;
}

const Plane front_place{0.16, 0.0}, rear_place{-0.16, 0.0};

struct Filmed {
  FilmCamera camera{.place = {-0.62, 0.0, 2.5}, .tilt = 0.25};
  cv::Mat front = aruco_picture(7), rear = aruco_picture(8);
  double height = car_height;
  std::function<bool(int)> hidden = [](int) { return false; };

  void write(const std::string& file) const {
    FilmRenderer renderer(camera, 3.0, 1);
    cv::VideoWriter film(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, camera.picture);
    ASSERT_TRUE(film.isOpened());
    film.set(cv::VIDEOWRITER_PROP_QUALITY, 95);
    for (int k = 0; k < frames; ++k) {
      const Pose pose = pose_at(k);
      std::vector<FlatPicture> scene;
      for (int id = 0; id < 4; ++id)
        scene.push_back({aruco_picture(id), 0.18, id % 2 == 0 ? -0.75 : 0.75, id < 2 ? -1.15 : 1.15,
                         0.3 * id, 0.0});
      const Plane f = at_body(pose, front_place), r = at_body(pose, rear_place);
      if (!hidden(k)) scene.push_back({front, side, f.real(), f.imag(), pose.yaw, height});
      scene.push_back({rear, side, r.real(), r.imag(), pose.yaw, height});
      film.write(renderer.render(scene));
    }
  }
};

const std::vector<std::string> on_ground{"0=-0.75,-1.15", "1=0.75,-1.15", "2=-0.75,1.15",
                                         "3=0.75,1.15"};

void write_lens_of(const FilmCamera& camera, const std::filesystem::path& file) {
  write_lens(file, {camera.matrix(), camera.distortion, camera.picture, 0.1});
}

// Root mean square and maximum of both markers' distances from the truth [mm].
struct Errors {
  double rms = 0.0, largest = 0.0;
  std::size_t frames = 0;
};

Errors errors_of(const MarkerTrack& track) {
  Errors errors{.frames = track.frames.size()};
  double squares = 0.0;
  for (const MarkerFrame& frame : track.frames) {
    const Pose pose =
        pose_at(static_cast<int>(std::lround(1e-9 * static_cast<double>(frame.t_ns) * rate)));
    for (const double off : {std::abs(frame.front - at_body(pose, front_place)),
                             std::abs(frame.rear - at_body(pose, rear_place))}) {
      errors.largest = std::max(errors.largest, 1e3 * off);
      squares += 1e6 * off * off;
    }
  }
  errors.rms = std::sqrt(squares / (2.0 * static_cast<double>(track.frames.size())));
  return errors;
}

std::string refusal(const TrackOptions& options) {
  return message_of([&options] {
    std::ostringstream csv;
    check(options);
    static_cast<void>(track_film(options, csv));
  });
}

// One film for several tests.
struct Stage {
  Scratch scratch;
  std::string film = scratch.path("film.avi").string();
  std::string lens = scratch.path("lens.yaml").string();
  TrackOptions options;

  Stage() {
    const Filmed filmed;
    filmed.write(film);
    write_lens_of(filmed.camera, lens);
    options.film = film;
    options.lens = lens;
    options.aruco = "4x4_50";
    options.front = 7;
    options.rear = 8;
    options.ground_markers = on_ground;
    options.height = car_height;
  }
};

const Stage& stage() {
  static const Stage made;
  return made;
}

MarkerTrack tracked(const TrackOptions& options, TrackSummary* summary = nullptr) {
  std::ostringstream csv;
  const TrackSummary found = track_film(options, csv);
  if (summary != nullptr) *summary = found;
  return read_marker_track(stage().scratch.write("track.csv", csv.str()));
}

// A pixel covers 4.8 mm on the ground.
TEST(Track, FindsArucoMarkersWithinMillimetresThroughATiltedCameraWithALens) {
  TrackSummary summary;
  const Errors errors = errors_of(tracked(stage().options, &summary));
  EXPECT_EQ(summary.frames, frames);
  EXPECT_GE(summary.front, frames - 1);
  EXPECT_GE(summary.rear, frames - 1);
  EXPECT_LT(errors.rms, 1.5);
  EXPECT_LT(errors.largest, 5.0);
}

// The markers' plane is 10 cm nearer to the camera: taken for the ground, it appears 4 % larger.
TEST(Track, CorrectsForTheHeightOfTheMarkersAndTheLens) {
  for (const std::string& lens : {stage().lens, std::string{}}) {
    TrackOptions options = stage().options;
    options.height = 0.0;
    options.lens = lens;
    EXPECT_GT(errors_of(tracked(options)).rms, 15.0) << lens;
  }
}

TEST(Track, ALostMarkerLeavesItsFieldsEmptyAndIsCounted) {
  const Scratch scratch;
  Filmed filmed;
  filmed.hidden = [](int frame) { return frame >= 10 && frame < 15; };
  TrackOptions options = stage().options;
  options.film = scratch.path("film.avi").string();
  filmed.write(options.film);
  TrackSummary summary;
  const MarkerTrack track = tracked(options, &summary);
  EXPECT_LE(summary.front, frames - 5);
  EXPECT_GE(summary.longest_gap, 5);
  EXPECT_EQ(track.frames.size() + track.gaps, static_cast<std::size_t>(frames));
  EXPECT_GE(track.gaps, 5U);
}

TEST(Track, WithoutGroundMarkersTheTrackIsInPixels) {
  TrackOptions options = stage().options;
  options.ground_markers.clear();
  options.lens.clear();
  options.height = 0.0;
  const MarkerTrack track = tracked(options);
  const Plane place = at_body(pose_at(0), front_place);
  const cv::Point2d pixel = Filmed{}.camera.pixel({place.real(), place.imag(), car_height});
  EXPECT_NEAR(track.frames[0].front.real(), pixel.x, 0.5);
  EXPECT_NEAR(track.frames[0].front.imag(), pixel.y, 0.5);
}

TEST(Track, TimesComeFromTheFilmOrTheRate) {
  TrackOptions options = stage().options;
  EXPECT_EQ(tracked(options).frames.at(1).t_ns, 20'000'000);
  options.frames_per_second = 200.0;
  EXPECT_EQ(tracked(options).frames.at(1).t_ns, 5'000'000);
}

TEST(Track, RefusesUnusableInputWithTheFix) {
  const auto written = [](const char* name, const char* text) {
    return stage().scratch.write(name, text).string();
  };
  const std::string small = stage().scratch.path("small.yaml").string();
  write_lens(small, {cv::Matx33d::eye(), {0, 0, 0, 0}, {320, 240}, 0});
  const std::string no_matrix = written("other.yaml", "%YAML:1.0\n---\nmatrix: 1\n"),
                    text = written("text.yaml", "hello"),
                    no_film = written("no.avi", "this is no film"),
                    nothing = stage().scratch.path("nothing.avi").string();
  struct Case {
    std::function<void(TrackOptions&)> change;
    const char* says;
  };
  const Case cases[]{
      {[](TrackOptions& o) { o.front = 9; }, "the front marker is in none of its 40 frames"},
      {[](TrackOptions& o) { o.ground_markers[3] = "17=0.75,1.15"; },
       "marker 17 is not seen on the ground"},
      {[](TrackOptions& o) {
         o.ground_markers = {"0=-0.75,1.15", "1=0.75,1.15", "2=-0.75,-1.15", "3=0.75,-1.15"};
       },
       "mirrored"},
      {[](TrackOptions& o) { o.aruco = "9x9_50"; }, "no dictionary"},
      {[&](TrackOptions& o) { o.lens = no_matrix; }, "camera_matrix"},
      {[&](TrackOptions& o) { o.lens = text; }, "text.yaml"},
      {[&](TrackOptions& o) { o.lens = small; }, "320 x 240"},
      {[&](TrackOptions& o) { o.film = no_film; }, "cannot be read as a film"},
      {[&](TrackOptions& o) { o.film = nothing; }, "no such file"}};
  for (const Case& one : cases) {
    TrackOptions options = stage().options;
    one.change(options);
    EXPECT_THAT(refusal(options), HasSubstr(one.says));
  }
}

TEST(Track, CalibratesTheLensFromAFilmOfAChessboard) {
  const Scratch scratch;
  const FilmCamera camera{.place = {0.0, 0.0, 0.9}};
  // 7 x 5 inner corners of 4 cm.
  cv::Mat board(7 * 40, 9 * 40, CV_8UC3, cv::Scalar(255, 255, 255));
  for (int row = 0; row < 5 + 1; ++row)
    for (int column = 0; column < 7 + 1; ++column)
      if ((row + column) % 2 == 0)
        cv::rectangle(board, cv::Rect(20 + 40 * column, 20 + 40 * row, 40, 40), cv::Scalar(0, 0, 0),
                      cv::FILLED);
  cv::Mat square(360, 360, CV_8UC3, cv::Scalar(255, 255, 255));
  board.copyTo(square(cv::Rect(0, 40, 360, 280)));

  TrackOptions options;
  options.film = scratch.path("board.avi").string();
  options.out = scratch.path("lens.yaml").string();
  options.calibrate = "7x5";
  options.square = 0.04;
  cv::VideoWriter film(options.film, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30.0,
                       camera.picture);
  film.set(cv::VIDEOWRITER_PROP_QUALITY, 95);
  // The board lies flat; the camera moves round it.
  for (int k = 0; k < 20; ++k) {
    FilmCamera moved = camera;
    moved.tilt = 0.45 * std::sin(1.3 * k);
    moved.heading = 0.9 * k;
    moved.place = {0.0, 0.0, 0.75 + 0.15 * std::cos(0.7 * k)};
    FilmRenderer renderer(moved, 2.0, static_cast<std::uint64_t>(k));
    const double ahead = moved.place[2] * std::tan(moved.tilt);
    const cv::Mat picture =
        renderer.render({{square, 0.36, ahead * std::cos(moved.heading) + 0.14 * std::sin(2.1 * k),
                          ahead * std::sin(moved.heading) + 0.14 * std::cos(2.9 * k), 0.0, 0.0}});
    for (int repeat = 0; repeat < 3; ++repeat) film.write(picture);
  }
  film.release();
  static_cast<void>(calibrate_lens(options));
  const Lens lens = read_lens(options.out);
  EXPECT_NEAR(lens.matrix(0, 0), camera.focal, 0.01 * camera.focal);
  EXPECT_EQ(lens.picture, camera.picture);
  const Lens truth{camera.matrix(), camera.distortion, camera.picture, 0.0};
  // Compares directions: in pixels, errors of focal length and distortion could cancel.
  for (const cv::Point2d pixel : {cv::Point2d{60, 60}, {320, 100}, {560, 400}}) {
    const auto direction = [&pixel](const Lens& l) {
      const cv::Point2d p = l.straightened(pixel);
      return cv::Point2d((p.x - l.matrix(0, 2)) / l.matrix(0, 0),
                         (p.y - l.matrix(1, 2)) / l.matrix(1, 1));
    };
    EXPECT_LT(cv::norm(direction(lens) - direction(truth)), 0.006) << pixel;
  }
  options.calibrate = "9x9";
  EXPECT_THAT(message_of([&] { static_cast<void>(calibrate_lens(options)); }),
              HasSubstr("9 x 9 inner corners in 0 different places"));
}

TEST(TrackCommand, FollowsTheMarkersOfASimulatedFilm) {
  const Scratch scratch;
  const std::string drive = scratch.path("drive"), film = scratch.path("film.avi"),
                    overlay = scratch.path("found.avi"), out = scratch.path("markers.csv");
  const std::string made = must_run(
      "odom sim --scenario circle --duration 4 --film-rate 10 --film " + film + " --out " + drive);
  const std::string says = "to track it: ";
  ASSERT_THAT(made, HasSubstr(says));
  std::string command = made.substr(made.find(says) + says.size());
  command.pop_back();
  EXPECT_THAT(run_shell(command + " --overlay " + overlay + " --out " + out),
              Ends(0, HasSubstr(" frames; front marker in")));
  EXPECT_THAT(run_shell("odom identify track nothing.avi --aruco 4x4_50 --front 1 --rear 2"),
              Ends(2, StartsWith("odom identify track: nothing.avi: no such file")));
  // The markers are 30 cm apart in every frame.
  const MarkerTrack track = read_marker_track(out);
  EXPECT_GT(track.frames.size(), 30U);
  for (const MarkerFrame& frame : track.frames)
    EXPECT_NEAR(std::abs(frame.front - frame.rear), 0.3, 0.005);
  cv::VideoCapture video(overlay);
  EXPECT_EQ(static_cast<int>(video.get(cv::CAP_PROP_FRAME_COUNT)),
            static_cast<int>(track.frames.size()));
}

}  // namespace
}  // namespace odomd::tools::track_test
