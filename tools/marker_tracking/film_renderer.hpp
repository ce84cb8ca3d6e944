// Films with known truth: a camera with a lens, markers on a moving car and on the ground, noise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace odomd::tools {

/// A camera above the ground, z up; OpenCV's distortion (k1, k2, p1, p2, k3).
struct FilmCamera {
  cv::Size picture{640, 480};
  double focal = 520.0;  ///< [px]
  std::vector<double> distortion{-0.18, 0.05, 0.001, -0.0005, 0.0};
  cv::Vec3d place{0.0, 0.0, 2.5};
  double tilt = 0.0;     ///< angle from straight down, about the picture's horizontal axis [rad]
  double heading = 0.0;  ///< of the picture's upward direction, projected on the ground [rad]

  [[nodiscard]] cv::Matx33d matrix() const;
  /// The pixel at which the camera sees a point of the world.
  [[nodiscard]] cv::Point2d pixel(const cv::Vec3d& point) const;
};

/// A flat picture that lies horizontally at a height, with the position and yaw of its middle.
struct FlatPicture {
  cv::Mat image;      ///< BGR
  double side = 0.1;  ///< width [m]
  double x = 0.0, y = 0.0, yaw = 0.0, height = 0.0;
};

/// An ArUco marker of 4x4_50 with a white rim; FlatPicture::side includes the rim.
[[nodiscard]] cv::Mat aruco_picture(int identifier);
/// Side of the marker / side of the picture with its rim.
inline constexpr double aruco_part = 0.75;

/// Renders scenes as seen by one camera.
class FilmRenderer {
 public:
  FilmRenderer(FilmCamera camera, double noise, std::uint64_t seed);

  [[nodiscard]] cv::Mat render(const std::vector<FlatPicture>& scene);

 private:
  /// Points of the plane z = height that the pixels see.
  [[nodiscard]] const cv::Mat& ground_map(double height);
  void paint(cv::Mat& frame, const FlatPicture& flat);

  FilmCamera camera_;
  cv::RNG random_;
  std::vector<cv::Mat> noise_;
  std::vector<std::pair<double, cv::Mat>> maps_;
};

/// Renders a simulated drive as a video from above, which odom identify track reads. The folder of
/// odom sim has truth.csv and plant.json, which gives the film's begin and rate. Two ArUco markers
/// are on the car, 8 cm above the ground; four lie around the drive. A camera with a lens looks
/// down, a little askew; its calibration goes to FILM.yaml. Returns the command that tracks the
/// markers. Throws std::invalid_argument for an unusable folder.
std::string render_film(const std::filesystem::path& drive, const std::filesystem::path& film);

}  // namespace odomd::tools
