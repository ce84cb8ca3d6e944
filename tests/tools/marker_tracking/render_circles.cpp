// Films a simulated drive from above, for a campaign: render_circles TRUTH.csv OUT.avi BEGIN RATE
// FRONT_X FRONT_Y REAR_X REAR_Y
// Two ArUco markers (7 in front, 8 behind) ride on the car, 8 cm above the ground; four (0 to 3)
// lie on the ground at (±1.8, ±3.3). The film begins BEGIN seconds after the truth. Writes the lens
// to OUT.avi.yaml.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <opencv2/videoio.hpp>
#include <span>
#include <vector>

#include "tests/tools/marker_tracking/film_renderer.hpp"
#include "tools/cli/csv.hpp"
#include "tools/marker_tracking/view.hpp"

namespace odomd::tools {
namespace {

struct Truth {
  std::int64_t t_ns = 0;
  double x = 0.0, y = 0.0, yaw = 0.0;
};

std::vector<Truth> read_truth(const std::string& file) {
  std::ifstream input(file);
  CsvReader reader(input, file, {"t", "x", "y", "yaw"});
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

void render(std::span<char*> arguments) {
  const std::vector<Truth> rows = read_truth(arguments[1]);
  const std::string out = arguments[2];
  const double begin = std::strtod(arguments[3], nullptr),
               rate = std::strtod(arguments[4], nullptr);
  std::vector<double> places;
  for (std::size_t k = 5; k < 9; ++k) places.push_back(std::strtod(arguments[k], nullptr));

  // 8 m across from 5 m above, a little askew: 6.3 mm a pixel on the ground.
  const FilmCamera camera{.picture = {1280, 720},
                          .focal = 800.0,
                          .distortion = {-0.12, 0.03, 0.0005, -0.0003, 0.0},
                          .place = {-0.3, 0.1, 5.0},
                          .tilt = 0.06,
                          .heading = 0.02};
  write_lens(out + ".yaml", {camera.matrix(), camera.distortion, camera.picture, 0.1});
  FilmRenderer renderer(camera, 3.0, 1);
  const cv::Mat front = aruco_picture(7), rear = aruco_picture(8);
  std::vector<FlatPicture> ground;
  for (int id = 0; id < 4; ++id)
    ground.push_back(
        {aruco_picture(id), 0.3, id < 2 ? -1.8 : 1.8, id % 2 == 0 ? -3.3 : 3.3, 0.0, 0.0});
  cv::VideoWriter film(out, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, camera.picture);
  film.set(cv::VIDEOWRITER_PROP_QUALITY, 90);
  for (int k = 0;; ++k) {
    const std::int64_t t = rows.front().t_ns + std::llround(1e9 * (begin + k / rate));
    if (t > rows.back().t_ns) break;
    const Truth car = at(rows, t);
    const double c = std::cos(car.yaw), s = std::sin(car.yaw);
    std::vector<FlatPicture> scene = ground;
    scene.push_back({front, 0.14, car.x + c * places[0] - s * places[1],
                     car.y + s * places[0] + c * places[1], car.yaw, 0.08});
    scene.push_back({rear, 0.14, car.x + c * places[2] - s * places[3],
                     car.y + s * places[2] + c * places[3], car.yaw, 0.08});
    film.write(renderer.render(scene));
  }
}

}  // namespace
}  // namespace odomd::tools

int main(int argc, char** argv) {
  if (argc != 9) {
    std::cerr << "usage: render_circles TRUTH.csv OUT.avi BEGIN RATE FX FY RX RY\n";
    return 2;
  }
  try {
    odomd::tools::render({argv, static_cast<std::size_t>(argc)});
  } catch (const std::exception& error) {
    std::cerr << "render_circles: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
