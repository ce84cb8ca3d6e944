#include "tools/marker_tracking/render_film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/progress.hpp"
#include "tools/marker_tracking/film_renderer.hpp"
#include "tools/marker_tracking/overlay.hpp"
#include "tools/marker_tracking/view.hpp"

namespace odomd::tools {
namespace {

constexpr int front_marker = 7, rear_marker = 8;
constexpr double marker_height = 0.08, side_on_car = 0.14, side_on_ground = 0.3;  // m

struct Truth {
  std::int64_t t_ns = 0;
  double x = 0.0, y = 0.0, yaw = 0.0;
};

std::vector<Truth> read_truth(const std::filesystem::path& file) {
  std::ifstream input = open_input(file);
  CsvReader reader(input, file.string(), {"t", "x", "y", "yaw"});
  std::vector<Truth> rows;
  while (reader.next())
    rows.push_back({reader.time_ns(0), reader.number(1), reader.number(2), reader.number(3)});
  return rows;
}

Truth at(const std::vector<Truth>& rows, std::int64_t t_ns) {
  const auto after = std::ranges::lower_bound(rows, t_ns, {}, &Truth::t_ns);
  if (after == rows.begin()) return rows.front();
  const Truth &a = *(after - 1), &b = *after;
  const double part = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  return {t_ns, a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), a.yaw + part * (b.yaw - a.yaw)};
}

/// The ground markers' places: around the drive, the camera above their middle.
std::vector<FlatPicture> ground_around(const std::vector<Truth>& rows) {
  const auto [left, right] = std::ranges::minmax(rows, {}, &Truth::x);
  const auto [low, high] = std::ranges::minmax(rows, {}, &Truth::y);
  constexpr double clear = 0.5;  // m
  std::vector<FlatPicture> ground;
  for (int id = 0; id < 4; ++id)
    ground.push_back({aruco_picture(id), side_on_ground, id < 2 ? left.x - clear : right.x + clear,
                      id % 2 == 0 ? low.y - clear : high.y + clear, 0.0, 0.0});
  return ground;
}

}  // namespace

std::string render_film(const std::filesystem::path& drive, const std::filesystem::path& film) {
  const std::vector<Truth> rows = read_truth(drive / "truth.csv");
  std::ifstream input = open_input(drive / "plant.json");
  const auto plant = nlohmann::json::parse(input);
  const auto truth = [&plant](const std::string& name) {
    return plant.at("truth").at(name).get<double>();
  };
  const auto place = [&](const std::string& end, std::size_t axis) {
    return plant.at("markers").at(end).at(axis).get<double>() +
           truth("marker_error_" + end + (axis == 0 ? "_x" : "_y"));
  };

  const std::vector<FlatPicture> ground = ground_around(rows);
  const FlatPicture &one = ground.front(), &other = ground.back();
  // Some 8 m across from 5 m above, a little askew.
  const double size = std::max({(other.x - one.x) / 4.6, (other.y - one.y) / 7.6, 0.5});
  const FilmCamera camera{.picture = {1280, 720},
                          .focal = 800.0,
                          .distortion = {-0.12, 0.03, 0.0005, -0.0003, 0.0},
                          .place = {0.5 * (one.x + other.x) - 0.3 * size,
                                    0.5 * (one.y + other.y) + 0.1 * size, 5.0 * size},
                          .tilt = 0.06,
                          .heading = 0.02};
  const std::string lens = film.string() + ".yaml";
  write_lens(lens, {camera.matrix(), camera.distortion, camera.picture, 0.1});
  constexpr double grey_noise = 3.0;
  FilmRenderer renderer(camera, grey_noise, plant.at("seed").get<std::uint64_t>());
  const double rate = truth("film_rate");
  cv::VideoWriter video = open_video(film, rate, camera.picture);

  const std::int64_t start_ns = plant.at("start_time_ns").get<std::int64_t>();
  const auto frame_ns = [&](std::int64_t frame) {
    return start_ns + std::llround(1e9 * (std::abs(truth("film_begin")) +
                                          static_cast<double>(frame) /
                                              (rate * (1.0 + truth("film_clock_error")))));
  };
  const cv::Mat front = aruco_picture(front_marker), rear = aruco_picture(rear_marker);
  ProgressLine progress("odom sim");
  const auto frames =
      std::llround(1e-9 * rate * static_cast<double>(rows.back().t_ns - frame_ns(0)));
  for (std::int64_t frame = 0; frame_ns(frame) <= rows.back().t_ns; ++frame) {
    const Truth car = at(rows, frame_ns(frame));
    const double c = std::cos(car.yaw), s = std::sin(car.yaw);
    std::vector<FlatPicture> scene = ground;
    for (const auto& [picture, end] : {std::pair{&front, "front"}, {&rear, "rear"}}) {
      const double x = place(end, 0), y = place(end, 1);
      scene.push_back({*picture, side_on_car, car.x + c * x - s * y, car.y + s * x + c * y, car.yaw,
                       marker_height});
    }
    video.write(renderer.render(scene));
    progress.show(fmt::format("frame {} of {}", frame, frames));
  }
  progress.end();
  std::string command = fmt::format(
      "odom identify track {} --lens {} --aruco 4x4_50 --front {} --rear {} --height {}",
      film.string(), lens, front_marker, rear_marker, marker_height);
  for (std::size_t id = 0; id < ground.size(); ++id)
    command += fmt::format(" --ground-marker {}={:.3f},{:.3f}", id, ground[id].x, ground[id].y);
  return command;
}

}  // namespace odomd::tools
