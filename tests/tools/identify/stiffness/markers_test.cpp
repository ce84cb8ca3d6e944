// From a film's markers to steady circles.
#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/identify/stiffness/film.hpp"

namespace odomd::tools::markers_test {
namespace {

using testing::SizeIs;

TEST(MarkerTrack, ReadsColumnsByNameInAnyOrderAndCountsGaps) {
  const Scratch scratch;
  const auto file = scratch.write("a.csv",
                                  "t,note,x_rear,y_rear,x_front,y_front\n"
                                  "0.0,a,1,2,3,4\n"
                                  "0.1,b,,,3,4\n"
                                  "\n"
                                  "0.2,c,1.5,2.5,3.5,4.5\r\n");
  const MarkerTrack track = read_marker_track(file);
  ASSERT_EQ(track.frames.size(), 2U);
  EXPECT_EQ(track.gaps, 1U);
  EXPECT_EQ(track.frames[1].t_ns, 200'000'000);
  EXPECT_EQ(track.frames[1].front, Plane(3.5, 4.5));
  EXPECT_EQ(track.frames[1].rear, Plane(1.5, 2.5));
}

TEST(MarkerTrack, NamesLineAndColumnOfBadInput) {
  const Scratch scratch;
  const std::string head = "t,x_front,y_front,x_rear,y_rear\n0,1,2,3,4\n";
  const std::pair<std::string, const char*> cases[]{
      {head + "0,1,2,3,4\n", "bad.csv:3: column \"t\""},
      {head + "-1,1,2,3,4\n", "sort the rows"},
      {head + "1,nan,2,3,4\n", "bad.csv:3: column \"x_front\""},
      {head + "1,1,2,3,x\n", "column \"y_rear\""},
      {head + "x,1,2,3,4\n", "not a time"},
      {"t,x,y\n0,1,2\n", "no column \"x_front\""},
      {"", "bad.csv"}};
  for (const auto& [text, says] : cases) {
    const auto file = scratch.write("bad.csv", text);
    EXPECT_THAT(message_of([&] { (void)read_marker_track(file); }), HasSubstr(says)) << text;
  }
}

// A film computed from a formula, without a tyre model: motion, alignment with the log, steady
// circles. The car is at rest, accelerates, circles and stops.

/// Speed, yaw rate and drift (in the car's frame) over time [s].
struct SyntheticDrive {
  std::function<double(double)> speed;
  std::function<double(double)> yaw_rate;
  double drift = 0.0;

  /// Rises within 1 s after `begin`, falls within 1 s before `end`.
  static double eased(double t, double begin, double end) {
    const auto ramp = [](double x) {
      return x <= 0.0 ? 0.0 : x >= 1.0 ? 1.0 : 0.5 - 0.5 * std::cos(3.141592653589793 * x);
    };
    return ramp(t - begin) * ramp(end - t);
  }
};

struct SyntheticFilm {
  MarkerTrack track;
  Series gyro;
};

/// `duration` seconds of film at 60 Hz; the gyro at 200 Hz, its clock ahead by `offset_s`.
SyntheticFilm make_film(const SyntheticDrive& drive, const MarkerPlaces& places, double duration,
                        double offset_s, double metres_per_unit = 1.0) {
  constexpr double step = 1.0 / 1200.0;
  SyntheticFilm film;
  film.track.name = "film.csv";
  Plane centre{};
  double heading = 0.4;
  const auto steps = static_cast<int>(duration / step);
  for (int k = 0; k < steps; ++k) {
    const double t = k * step;
    if (k % 20 == 0) {
      const Plane turn = std::polar(1.0, heading);
      film.track.frames.push_back({std::llround(1e9 * t),
                                   (centre + turn * places.front) / metres_per_unit,
                                   (centre + turn * places.rear) / metres_per_unit});
    }
    if (k % 6 == 0) {
      film.gyro.add(std::llround(1e9 * (t + offset_s)), drive.yaw_rate(t));
    }
    const double middle = heading + 0.5 * step * drive.yaw_rate(t + 0.5 * step);
    centre += step * drive.speed(t + 0.5 * step) * std::polar(1.0, middle + drive.drift);
    heading += step * drive.yaw_rate(t + 0.5 * step);
  }
  return film;
}

const MarkerPlaces places{Plane{0.18, 0.01}, Plane{-0.12, -0.02}};
constexpr FilmScale metres{.metres_per_unit = 1.0};

// A left circle, a pause, a faster right circle.
SyntheticDrive two_circles() {
  return {.speed =
              [](double t) {
                return 1.0 * SyntheticDrive::eased(t, 1.0, 13.0) +
                       1.5 * SyntheticDrive::eased(t, 15.0, 25.0);
              },
          .yaw_rate =
              [](double t) {
                return 0.8 * SyntheticDrive::eased(t, 1.0, 13.0) -
                       1.2 * SyntheticDrive::eased(t, 15.0, 25.0);
              },
          .drift = 0.05};
}

/// The two circles in a film whose log is ahead by `offset_s`.
struct Filmed {
  explicit Filmed(double offset_s) : film(make_film(two_circles(), places, 26.0, offset_s)) {}
  SyntheticFilm film;
  FilmMotion motion = film_motion(film.track, places, metres);
};

TEST(FilmMotion, FindsTheCentreOfGravityBetweenTheMarkers) {
  const auto [film, motion] = Filmed(0.0);
  EXPECT_NEAR(std::abs(motion.frames.front().centre), 0.0, 1e-9);
  EXPECT_NEAR(motion.frames.front().heading, 0.4, 1e-9);
  const auto local = local_motion(motion, 6'000'000'000, 500'000'000);
  ASSERT_TRUE(local);
  EXPECT_NEAR(std::abs(local->velocity), 1.0, 1e-4);
  EXPECT_NEAR(local->yaw_rate, 0.8, 1e-4);
  EXPECT_NEAR(local->drift(), 0.05, 1e-4);
}

TEST(FilmMotion, GetsTheScaleFromTheMarkersAndMirrorsYDown) {
  SyntheticFilm film = make_film(two_circles(), places, 10.0, 0.0, 0.0025);
  for (MarkerFrame& frame : film.track.frames) {
    frame.front = std::conj(frame.front);
    frame.rear = std::conj(frame.rear);
  }
  const FilmMotion motion = film_motion(film.track, places, {.axes = ImageAxes::y_down});
  EXPECT_NEAR(motion.metres_per_unit, 0.0025, 1e-9);
  const auto local = local_motion(motion, 6'000'000'000, 500'000'000);
  ASSERT_TRUE(local);
  EXPECT_NEAR(local->yaw_rate, 0.8, 1e-4);
  EXPECT_NEAR(local->drift(), 0.05, 1e-4);
}

TEST(FilmMotion, LeavesOutFramesThatTrackedAnotherObject) {
  SyntheticFilm film = make_film(two_circles(), places, 10.0, 0.0);
  film.track.frames[100].front += Plane{0.2, 0.0};
  const FilmMotion motion = film_motion(film.track, places, metres);
  EXPECT_EQ(motion.frames.size(), film.track.frames.size() - 1);
  EXPECT_THAT(motion.warnings, Contains(diagnostics::Named("film_rows_left_out", "1 frame")));
}

TEST(FilmMotion, WarnsOfOrRefusesAScaleThatContradictsTheMarkers) {
  const SyntheticFilm film = make_film(two_circles(), places, 5.0, 0.0, 0.0025);
  const auto warnings_by = [&](double metres_per_unit) {
    return film_motion(film.track, places,
                       {.metres_per_unit = metres_per_unit, .ratio_sigma = 0.006})
        .warnings;
  };
  EXPECT_THAT(warnings_by(0.0026),
              Contains(diagnostics::Named("film_scale_off", "4.0 % more than the 0.3015 m")));
  EXPECT_THAT(warnings_by(0.00253), testing::IsEmpty());
  EXPECT_THAT(
      message_of([&] { (void)film_motion(film.track, places, {.metres_per_unit = 0.003}); }),
      HasSubstr("correct the scale"));
}

TEST(FilmAlignment, FindsTheShiftBetweenFilmAndLog) {
  const auto [film, motion] = Filmed(100.2345);
  const FilmAlignment found = align_film("film.csv", motion, film.gyro);
  EXPECT_NEAR(1e-9 * static_cast<double>(found.offset_ns), 100.2345, 0.005);
  EXPECT_LT(found.sigma_s, 0.02);
  EXPECT_THAT(found.warnings, testing::IsEmpty());
}

// As filmed by a camera whose clock runs at another rate.
TEST(FilmAlignment, AcceptsTwoQuartzClocksAndWarnsOfAnotherRate) {
  for (const double by : {0.9999, 1.001, 1.03, 0.97}) {
    auto [film, motion] = Filmed(100.2345);
    for (BodyFrame& frame : motion.frames)
      frame.t_ns = std::llround(by * static_cast<double>(frame.t_ns));
    const FilmAlignment found = align_film("film.csv", motion, film.gyro);
    const bool usual = std::abs(by - 1.0) < 0.002;
    EXPECT_EQ(found.warnings.size(), usual ? 0U : 1U) << by;
    if (usual) {
      EXPECT_NEAR(1e-9 * static_cast<double>(found.offset_ns), 100.2345, 2.0 * found.sigma_s) << by;
    }
  }
}

TEST(FilmAlignment, RefusesFilmsOfAnotherDriveWithTheReason) {
  const auto [film, motion] = Filmed(3.0);
  Series mirrored = film.gyro;
  for (double& value : mirrored.value) value = -value;
  EXPECT_THAT(message_of([&] { (void)align_film("film.csv", motion, mirrored); }),
              HasSubstr("--y-down"));
  Series other = film.gyro;
  for (std::size_t k = 0; k < other.size(); ++k)
    other.value[k] = 0.6 * std::sin(4e-9 * static_cast<double>(other.t_ns[k]));
  EXPECT_THAT(message_of([&] { (void)align_film("film.csv", motion, other); }),
              HasSubstr("do not overlap"));
  // The film played at half speed.
  FilmMotion slow = motion;
  for (BodyFrame& frame : slow.frames) frame.t_ns *= 2;
  EXPECT_THAT(message_of([&] { (void)align_film("film.csv", slow, film.gyro); }),
              HasSubstr("--fps"));
}

TEST(FilmAlignment, RefusesAFilmThatHardlyShowsTheMarkers) {
  auto [film, motion] = Filmed(3.0);
  std::erase_if(motion.frames, [](const BodyFrame& frame) {
    return frame.t_ns > 2'000'000'000 && frame.t_ns < 24'000'000'000;
  });
  EXPECT_THAT(message_of([&] { (void)align_film("film.csv", motion, film.gyro); }),
              HasSubstr("both markers are seen often enough in only 4 s of 26 s of film"));
}

// A log with the gyro and, until `steered_until_ns`, a quarter of its rate as steering.
SignalLog log_of(const Series& gyro, std::int64_t steered_until_ns) {
  SignalLog log;
  log.of(estimator::Source::yaw_rate) = gyro;
  Series& steering = log.of(estimator::Source::steering);
  for (std::size_t k = 0; k < gyro.size() && gyro.t_ns[k] <= steered_until_ns; ++k) {
    steering.add(gyro.t_ns[k], 0.25 * gyro.value[k]);
  }
  return log;
}

TEST(CircleRuns, FindsAndMeasuresSteadyParts) {
  const auto [film, motion] = Filmed(5.0);
  const SignalLog log = log_of(film.gyro, film.gyro.t_ns.back());
  diagnostics::Diagnostics warnings;
  const auto runs = measure_circles("film.csv", motion, log, 5'000'000'000, 0.0, warnings);
  ASSERT_THAT(runs, SizeIs(2));
  EXPECT_NEAR(runs[0].speed, 1.0, 1e-3);
  EXPECT_NEAR(runs[0].yaw_rate, 0.8, 1e-3);
  EXPECT_NEAR(runs[0].drift.value, 0.05, 1e-3);
  EXPECT_NEAR(runs[0].steering.value, 0.2, 1e-3);
  EXPECT_NEAR(runs[0].radius(), 1.25, 5e-3);
  EXPECT_NEAR(runs[1].yaw_rate, -1.2, 2e-3);
  EXPECT_NEAR(runs[1].lateral_accel, -1.8 * std::cos(0.05), 5e-3);
  EXPECT_THAT(warnings, testing::IsEmpty());
}

TEST(CircleRuns, LeavesOutACircleWithoutSteering) {
  const auto [film, motion] = Filmed(5.0);
  const SignalLog log = log_of(film.gyro, 19'000'000'000);  // before the second circle
  diagnostics::Diagnostics warnings;
  const auto runs = measure_circles("film.csv", motion, log, 5'000'000'000, 0.0, warnings);
  ASSERT_THAT(runs, SizeIs(1));
  EXPECT_NEAR(runs[0].steering.value, 0.2, 1e-3);
  EXPECT_THAT(warnings,
              testing::ElementsAre(diagnostics::Named("circle_left_out", "0 samples of steering")));
}

TEST(CircleRuns, FindsNoCircleInAWobble) {
  const SyntheticDrive wobble{
      .speed = [](double t) { return 1.5 * SyntheticDrive::eased(t, 1.0, 20.0); },
      .yaw_rate = [](double t) { return 1.2 + 0.6 * std::sin(2.0 * t); }};
  const SyntheticFilm film = make_film(wobble, places, 20.0, 0.0);
  const SignalLog log = log_of(film.gyro, film.gyro.t_ns.back());
  diagnostics::Diagnostics warnings;
  EXPECT_THAT(
      measure_circles("film.csv", film_motion(film.track, places, metres), log, 0, 0.0, warnings),
      testing::IsEmpty());
  EXPECT_THAT(warnings, testing::IsEmpty());  // so there is no other reason
}

}  // namespace
}  // namespace odomd::tools::markers_test
