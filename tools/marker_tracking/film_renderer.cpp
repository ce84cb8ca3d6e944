#include "tools/marker_tracking/film_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/marker_tracking/film.hpp"

namespace odomd::tools {
namespace {

// The rows are the camera's right, down and forward axes in the world.
cv::Matx33d orientation(const FilmCamera& camera) {
  const double c = std::cos(camera.heading), s = std::sin(camera.heading);
  const cv::Vec3d up{c, s, 0.0}, right{s, -c, 0.0}, below{0.0, 0.0, -1.0};
  const cv::Vec3d forward = std::cos(camera.tilt) * below + std::sin(camera.tilt) * up;
  const cv::Vec3d down = forward.cross(right);
  return {right[0], right[1],   right[2],   down[0],   down[1],
          down[2],  forward[0], forward[1], forward[2]};
}

}  // namespace

cv::Matx33d FilmCamera::matrix() const {
  return {focal, 0.0, 0.5 * (picture.width - 1), 0.0, focal, 0.5 * (picture.height - 1), 0.0,
          0.0,   1.0};
}

cv::Point2d FilmCamera::pixel(const cv::Vec3d& point) const {
  const cv::Matx33d r = orientation(*this);
  cv::Mat rotation;
  cv::Rodrigues(cv::Mat(r), rotation);
  const std::vector<cv::Point3d> points{cv::Point3d(point)};
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, rotation, cv::Mat(r * (-1.0 * place)), matrix(), distortion, pixels);
  return pixels.front();
}

cv::Mat aruco_picture(int identifier) {
  constexpr int inner = 240, rim = 40;
  static_assert(inner == static_cast<int>(aruco_part * (inner + 2 * rim)));
  cv::Mat marker, whole, colour;
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50), identifier,
                        inner, marker);
  cv::copyMakeBorder(marker, whole, rim, rim, rim, rim, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::cvtColor(whole, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

FilmRenderer::FilmRenderer(FilmCamera camera, double noise, std::uint64_t seed)
    : camera_(std::move(camera)), random_(seed) {
  for (int k = 0; k < 4; ++k) {
    cv::Mat frame(camera_.picture, CV_16SC3);
    random_.fill(frame, cv::RNG::NORMAL, 0.0, noise);
    noise_.push_back(frame);
  }
}

const cv::Mat& FilmRenderer::ground_map(double height) {
  for (const auto& [known, map] : maps_)
    if (known == height) return map;
  std::vector<cv::Point2d> pixels, rays;
  for (int v = 0; v < camera_.picture.height; ++v)
    for (int u = 0; u < camera_.picture.width; ++u) pixels.emplace_back(u, v);
  cv::undistortPoints(pixels, rays, camera_.matrix(), camera_.distortion, cv::noArray(),
                      cv::noArray(), {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-10});
  const cv::Matx33d to_world = orientation(camera_).t();
  cv::Mat map(camera_.picture, CV_64FC2);
  for (int v = 0; v < map.rows; ++v)
    for (int u = 0; u < map.cols; ++u) {
      const cv::Point2d& ray = rays[static_cast<std::size_t>(v * map.cols + u)];
      const cv::Vec3d d = to_world * cv::Vec3d(ray.x, ray.y, 1.0);
      const double distance = (height - camera_.place[2]) / d[2];
      map.at<cv::Vec2d>(v, u) = {camera_.place[0] + distance * d[0],
                                 camera_.place[1] + distance * d[1]};
    }
  return maps_.emplace_back(height, map).second;
}

// Each pixel that may see the picture is the mean of 4 x 4 samples of it.
void FilmRenderer::paint(cv::Mat& frame, const FlatPicture& flat) {
  const cv::Mat& map = ground_map(flat.height);
  const double c = std::cos(flat.yaw), s = std::sin(flat.yaw);
  const double half = 0.5 * flat.side;
  std::vector<cv::Point2d> corners;
  for (const auto& [x, y] : {std::pair{half, half}, {half, -half}, {-half, half}, {-half, -half}})
    corners.push_back(camera_.pixel({flat.x + c * x - s * y, flat.y + s * x + c * y, flat.height}));
  const auto [left, right] = std::ranges::minmax(corners, {}, &cv::Point2d::x);
  const auto [top, bottom] = std::ranges::minmax(corners, {}, &cv::Point2d::y);
  const int first_u = std::max(0, static_cast<int>(left.x) - 2);
  const int last_u = std::min(map.cols - 2, static_cast<int>(right.x) + 2);
  const int first_v = std::max(0, static_cast<int>(top.y) - 2);
  const int last_v = std::min(map.rows - 2, static_cast<int>(bottom.y) + 2);
  const double scale = flat.image.cols / flat.side;
  for (int v = std::max(first_v, 1); v <= last_v; ++v)
    for (int u = std::max(first_u, 1); u <= last_u; ++u) {
      const cv::Vec2d middle = map.at<cv::Vec2d>(v, u);
      const cv::Vec2d along = 0.5 * (map.at<cv::Vec2d>(v, u + 1) - map.at<cv::Vec2d>(v, u - 1));
      const cv::Vec2d across = 0.5 * (map.at<cv::Vec2d>(v + 1, u) - map.at<cv::Vec2d>(v - 1, u));
      cv::Vec3d sum;
      const cv::Vec3b under = frame.at<cv::Vec3b>(v, u);
      for (int sample = 0; sample < 16; ++sample) {
        const cv::Vec2d place = middle + ((sample % 4) / 4.0 - 0.375) * along +
                                (std::floor(sample / 4.0) / 4.0 - 0.375) * across;
        const double dx = place[0] - flat.x, dy = place[1] - flat.y;
        // Rows of the picture run against the body's x axis, columns against its y axis.
        const int row = static_cast<int>(std::floor((half - (c * dx + s * dy)) * scale));
        const int column = static_cast<int>(std::floor((half - (-s * dx + c * dy)) * scale));
        const bool on =
            row >= 0 && column >= 0 && row < flat.image.rows && column < flat.image.cols;
        sum += cv::Vec3d(on ? flat.image.at<cv::Vec3b>(row, column) : under);
      }
      frame.at<cv::Vec3b>(v, u) = cv::Vec3b(sum / 16.0);
    }
}

cv::Mat FilmRenderer::render(const std::vector<FlatPicture>& scene) {
  cv::Mat frame(camera_.picture, CV_8UC3, cv::Scalar(150, 155, 160));
  for (const FlatPicture& flat : scene) paint(frame, flat);
  cv::GaussianBlur(frame, frame, {3, 3}, 0.6);
  cv::Mat noisy;
  cv::add(frame, noise_[static_cast<std::size_t>(random_.uniform(0, 4))], noisy, cv::noArray(),
          CV_8UC3);
  return noisy;
}

namespace {

constexpr int front_marker = 7, rear_marker = 8;
constexpr double marker_height = 0.08, side_on_car = 0.14, side_on_ground = 0.3;  // m

/// The markers on the ground, around the drive.
std::vector<FlatPicture> ground_around(const std::vector<TrajectoryPoint>& rows) {
  const auto x_of = [](const TrajectoryPoint& row) { return row.pose.x; };
  const auto y_of = [](const TrajectoryPoint& row) { return row.pose.y; };
  const auto [left, right] = std::ranges::minmax(rows, {}, x_of);
  const auto [low, high] = std::ranges::minmax(rows, {}, y_of);
  constexpr double clear = 0.5;  // m
  std::vector<FlatPicture> ground;
  for (int id = 0; id < 4; ++id)
    ground.push_back({aruco_picture(id), side_on_ground,
                      id < 2 ? left.pose.x - clear : right.pose.x + clear,
                      id % 2 == 0 ? low.pose.y - clear : high.pose.y + clear, 0.0, 0.0});
  return ground;
}

}  // namespace

std::string render_film(const std::filesystem::path& drive, const std::filesystem::path& film) {
  const Trajectory driven = read_trajectory(drive / "truth.csv");
  std::ifstream input = open_input(drive / "plant.json");
  const auto plant = nlohmann::json::parse(input);
  const auto truth = [&plant](const std::string& name) {
    return plant.at("truth").at(name).get<double>();
  };
  const auto place = [&](const std::string& end, std::size_t axis) {
    return plant.at("markers").at(end).at(axis).get<double>() +
           truth("marker_error_" + end + (axis == 0 ? "_x" : "_y"));
  };

  const std::vector<FlatPicture> ground = ground_around(driven.points);
  const FlatPicture &one = ground.front(), &other = ground.back();
  // At size 1 the view is 8 m across from 5 m above, a little askew.
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
      std::llround(1e-9 * rate * static_cast<double>(driven.points.back().t_ns - frame_ns(0)));
  for (std::int64_t frame = 0; frame_ns(frame) <= driven.points.back().t_ns; ++frame) {
    const estimator::Pose2 car = at(driven, frame_ns(frame)).value_or(driven.points.front()).pose;
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
