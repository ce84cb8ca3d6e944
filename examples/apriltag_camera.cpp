// A camera process: finds AprilTags (36h11) in pictures, and sends the car's pose to odomd.
// docs/camera.md describes how to use it.
// The unknowns are the car's x, y and yaw and, with the sigmas of the setup as prior, its height,
// roll and pitch and each tag's x, y, z and yaw. The pose minimises, over the corners of all tags,
//   chi2 = sum |observed - projected|^2 / sigma_corner^2 + sum (unknown - prior)^2 / sigma^2,
// which weights each tag by its covariance. The pose's covariance is P = s2 (J'J)^-1 (Hartley and
// Zisserman, Multiple View Geometry, section 5.2), s2 = max(1, chi2 / (8 tags - 3)). A single tag
// fits two poses (Collins and Bartoli, Infinitesimal plane-based pose estimation, 2014): both are
// fitted. The second one has the weight w = exp(-(chi2 - best chi2) / (2 s2)) and differs from the
// best by d; the covariance of the mixture is (P + w (P2 + d d')) / (1 + w).
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <toml++/toml.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <odom/odom.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using std::chrono::steady_clock;
constexpr double degree = CV_PI / 180.0;
constexpr double max_misfit = 3.0;  // corner sigmas, rms; beyond it the tags contradict the setup

struct Tag {
  double size = 0.0;  // side of the square whose corners are found [m]
  cv::Affine3d pose;  // in the map or on the car; x points out of the print, z up
};

struct Sighting {
  const Tag* tag;
  std::vector<cv::Point2d> corners;  // upper left, upper right, lower right, lower left
};

struct Setup {
  double max_hamming = 0.0, stamp_offset = 0.0, sigma_corner = 0.0;
  bool camera_on_car = true;
  cv::Affine3d camera;  // on the car or in the map; x forward, z up
  cv::Mat matrix, distortion;
  cv::Size picture;
  std::vector<double> sigma_car, sigma_tag;  // x, y, yaw, z, roll, pitch; x, y, z, yaw
  std::map<int, Tag> tags;
};

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw std::invalid_argument(where + ": " + what);
}

cv::Affine3d pose_of(const cv::Vec3d& place, double yaw, double pitch, double roll) {
  return cv::Affine3d(cv::Vec3d(0, 0, yaw), place) * cv::Affine3d(cv::Vec3d(0, pitch, 0)) *
         cv::Affine3d(cv::Vec3d(roll, 0, 0));
}

/// A table of the setup. Reading a key removes it; a key that is left over is a mistake.
struct Table {
  toml::table& rest;
  std::string file, name;

  [[noreturn]] void refuse(std::string_view key, const std::string& needed) const {
    const toml::node* node = rest.get(key);
    const auto line = (node == nullptr ? rest.source() : node->source()).begin.line;
    fail(file + (line == 0 ? "" : ':' + std::to_string(line)),
         name + std::string(key) + (node == nullptr ? " is missing: " : " is wrong: ") + needed);
  }
  double number(const char* key, double fallback = NAN, double above = -INFINITY) {
    const double value = rest.contains(key) ? rest[key].value<double>().value_or(NAN) : fallback;
    if (!std::isfinite(value) || value <= above)
      refuse(key, above < 0.0 ? "a number is needed" : "a number above 0 is needed");
    rest.erase(key);
    return value;
  }
  cv::Affine3d pose() {
    return pose_of({number("x"), number("y"), number("z")}, number("yaw_deg", 0.0) * degree,
                   number("pitch_deg", 0.0) * degree, number("roll_deg", 0.0) * degree);
  }
  void finish() const {
    for (const auto& [key, node] : rest) refuse(key.str(), "docs/camera.md has no such key");
  }
};

void read_calibration(const std::string& file, Setup& setup) try {
  const cv::FileStorage calibration(file, cv::FileStorage::READ);
  calibration["camera_matrix"] >> setup.matrix;
  calibration["distortion_coefficients"] >> setup.distortion;
  setup.picture = {static_cast<int>(calibration["image_width"]),
                   static_cast<int>(calibration["image_height"])};
  setup.matrix.convertTo(setup.matrix, CV_64F);
  if (setup.matrix.size() != cv::Size(3, 3) || setup.matrix.at<double>(0, 0) <= 0.0 ||
      !cv::checkRange(setup.matrix) || setup.picture.empty() || setup.distortion.total() < 4 ||
      !cv::checkRange(setup.distortion))
    fail(file, "camera_matrix, distortion_coefficients, image_width and image_height are needed");
  cv::getOptimalNewCameraMatrix(setup.matrix, setup.distortion, setup.picture, 0.0);  // may throw
} catch (const cv::Exception&) {
  fail(file, "is not a calibration as OpenCV writes it (YAML that begins with %YAML:1.0)");
}

Setup read_setup(const std::string& file, const std::string& lens) try {
  toml::table document = toml::parse_file(file);
  Table root{document, file, ""};
  toml::table* const given = document["camera"].as_table();
  if (given == nullptr) root.refuse("camera", "a table [camera] is needed");
  Setup setup;
  read_calibration(lens, setup);
  Table camera{*given, file, "[camera] "};
  const auto on_car = camera.rest["on_car"].value_exact<bool>();
  if (!on_car) camera.refuse("on_car", "true or false is needed");
  setup.camera_on_car = *on_car;
  camera.rest.erase("on_car");
  setup.camera = camera.pose();
  setup.stamp_offset = camera.number("stamp_offset", 0.0);
  setup.max_hamming = camera.number("max_hamming", 0.0);
  setup.sigma_corner = camera.number("sigma_corner", 0.3, 0.0);
  const double tilt = camera.number("sigma_tilt_deg", 0.5, 0.0) * degree;
  const double height = camera.number("sigma_z", 0.005, 0.0);
  setup.sigma_car = {INFINITY, INFINITY, INFINITY, height, tilt, tilt};
  setup.sigma_tag.assign(3, camera.number("sigma_tag", 0.002, 0.0));
  setup.sigma_tag.push_back(camera.number("sigma_tag_deg", 0.2, 0.0) * degree);
  camera.finish();
  toml::array* tags = document["tag"].as_array();
  if (tags == nullptr || !tags->is_homogeneous<toml::table>())
    root.refuse("tag", "a table [[tag]] for each tag is needed");
  for (toml::node& node : *tags) {
    Table tag{*node.as_table(), file, "[[tag]] "};
    const int id = tag.rest["id"].value<int>().value_or(-1);
    if (id < 0 || setup.tags.find(id) != setup.tags.end())
      tag.refuse("id", "a whole number that no other tag has is needed");
    setup.tags[id] = {tag.number("size", NAN, 0.0), tag.pose()};
    tag.rest.erase("id");
    tag.finish();
  }
  for (const char* key : {"camera", "tag"}) document.erase(key);
  root.finish();
  return setup;
} catch (const toml::parse_error& error) {
  fail(file + ':' + std::to_string(error.source().begin.line), std::string(error.description()));
}

std::vector<Sighting> find_tags(const Setup& setup, const cv::Mat& grey) {
  static apriltag_detector_t* const detector = apriltag_detector_create();
  if (zarray_size(detector->tag_families) == 0)
    apriltag_detector_add_family_bits(detector, tag36h11_create(), 2);
  image_u8_t image{grey.cols, grey.rows, static_cast<int>(grey.step), grey.data};
  zarray_t* const found = apriltag_detector_detect(detector, &image);
  std::vector<Sighting> sightings;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* seen = nullptr;
    zarray_get(found, i, static_cast<void*>(&seen));
    const auto tag = setup.tags.find(seen->id);
    if (tag == setup.tags.end() || seen->hamming > setup.max_hamming) continue;
    sightings.push_back({&tag->second, {}});
    for (const int corner : {3, 2, 1, 0})  // OpenCV: pixel centres are integers
      sightings.back().corners.emplace_back(seen->p[corner][0] - 0.5, seen->p[corner][1] - 0.5);
  }
  apriltag_detections_destroy(found);
  return sightings;
}

const cv::Affine3d from_optical(cv::Matx33d(0, 0, 1, -1, 0, 0, 0, -1, 0));  // x right, y down
const cv::Affine3d from_print(cv::Matx33d(0, 0, 1, 1, 0, 0, 0, 1, 0));      // x right, y up

std::vector<cv::Point3d> print_corners(const Tag& tag) {
  const double h = 0.5 * tag.size;
  return {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
}

/// The residuals over their sigmas. Unknowns: x, y, yaw, z, roll, pitch; of each tag x, y, z, yaw.
struct Residuals : cv::LMSolver::Callback {
  const Setup& setup;
  const std::vector<Sighting>& sightings;
  std::vector<double> prior;  // sigmas
  Residuals(const Setup& s, const std::vector<Sighting>& seen)
      : setup(s), sightings(seen), prior(s.sigma_car) {
    for (std::size_t i = 0; i < 4 * seen.size(); ++i) prior.push_back(s.sigma_tag[i % 4]);
  }

  [[nodiscard]] cv::Mat at(const cv::Mat& unknowns) const {
    const auto* p = unknowns.ptr<double>();
    const cv::Affine3d car = pose_of({p[0], p[1], p[3]}, p[2], p[5], p[4]);
    std::vector<double> residuals;
    for (std::size_t i = 0; i < prior.size(); ++i) residuals.push_back(p[i] / prior[i]);
    for (const Sighting& seen : sightings) {
      const double* q = p + 6 + 4 * (&seen - sightings.data());
      const cv::Vec3d place = seen.tag->pose.translation() + cv::Vec3d(q[0], q[1], q[2]);
      const cv::Affine3d tag =
          cv::Affine3d(cv::Vec3d(0, 0, q[3]), place) * cv::Affine3d(seen.tag->pose.rotation());
      const cv::Affine3d in_camera = from_optical.inv() * setup.camera.inv() *
                                     (setup.camera_on_car ? car.inv() : car) * tag * from_print;
      std::vector<cv::Point2d> pixels;
      cv::projectPoints(print_corners(*seen.tag), in_camera.rvec(), in_camera.translation(),
                        setup.matrix, setup.distortion, pixels);
      const cv::Mat errors = (cv::Mat(pixels) - cv::Mat(seen.corners)) / setup.sigma_corner;
      residuals.insert(residuals.end(), errors.ptr<double>(), errors.ptr<double>() + 8);
    }
    return cv::Mat(residuals, true);
  }

  bool compute(cv::InputArray unknowns, cv::OutputArray residuals,
               cv::OutputArray jacobian) const override {
    constexpr double step = 1e-6;
    const cv::Mat p = unknowns.getMat();
    at(p).copyTo(residuals);
    if (!jacobian.needed()) return true;
    cv::Mat rows;
    for (int i = 0; i < p.rows; ++i) {
      cv::Mat moved = p.clone();
      moved.at<double>(i) += step;
      rows.push_back(cv::Mat((at(moved) - residuals.getMat()).t() / step));
    }
    cv::transpose(rows, jacobian);
    return true;
  }
};

/// x, y, yaw and their sigmas; nothing if the tags contradict the setup.
std::optional<cv::Vec6d> estimate(const Setup& setup, const std::vector<Sighting>& sightings) {
  struct Fit {
    double chi2;
    cv::Vec3d pose, variance;
  };
  const Sighting& largest =
      *std::max_element(sightings.begin(), sightings.end(), [](const auto& a, const auto& b) {
        return cv::norm(a.corners[0] - a.corners[2]) < cv::norm(b.corners[0] - b.corners[2]);
      });
  std::vector<cv::Mat> turns, shifts;
  cv::solvePnPGeneric(print_corners(*largest.tag), largest.corners, setup.matrix, setup.distortion,
                      turns, shifts, false, cv::SOLVEPNP_IPPE_SQUARE);
  const auto residuals = cv::makePtr<Residuals>(setup, sightings);
  std::vector<Fit> fits;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const cv::Affine3d tag =
        setup.camera * from_optical * cv::Affine3d(turns[i], shifts[i]) * from_print.inv();
    const cv::Affine3d car =
        setup.camera_on_car ? largest.tag->pose * tag.inv() : tag * largest.tag->pose.inv();
    cv::Mat p = cv::Mat::zeros(static_cast<int>(residuals->prior.size()), 1, CV_64F);
    p.at<double>(0) = car.translation()[0];
    p.at<double>(1) = car.translation()[1];
    p.at<double>(2) = std::atan2(car.rotation()(1, 0), car.rotation()(0, 0));
    cv::LMSolver::create(residuals, 50)->run(p);
    cv::Mat left, jacobian;
    cv::Mat_<double> c;
    residuals->compute(p, left, jacobian);
    if (cv::invert(jacobian.t() * jacobian, c, cv::DECOMP_CHOLESKY) != 0.0 && cv::checkRange(p))
      fits.push_back({left.dot(left), cv::Vec3d(p.ptr<double>()), {c(0, 0), c(1, 1), c(2, 2)}});
  }
  if (fits.empty()) return std::nullopt;
  if (fits.back().chi2 < fits.front().chi2) std::swap(fits.front(), fits.back());
  const Fit &best = fits.front(), &second = fits.back();
  const double s2 = std::max(1.0, best.chi2 / (8.0 * static_cast<double>(sightings.size()) - 3.0));
  if (s2 > max_misfit * max_misfit) return std::nullopt;
  const double w = std::exp(-0.5 * (second.chi2 - best.chi2) / s2);
  cv::Vec3d d = second.pose - best.pose;
  d[2] = std::remainder(d[2], 2.0 * CV_PI);
  cv::Vec6d result(best.pose[0], best.pose[1], std::remainder(best.pose[2], 2.0 * CV_PI));
  for (int i = 0; i < 3; ++i)
    result[3 + i] =
        std::sqrt((s2 * (best.variance[i] + w * second.variance[i]) + w * d[i] * d[i]) / (1.0 + w));
  return result;
}

odom_clock clock_of(std::int64_t stamp_ns, const std::string& source) {
  const auto age = [&](auto now) { return std::abs(now.time_since_epoch().count() - stamp_ns); };
  if (age(steady_clock::now()) < 10000000000) return ODOM_CLOCK_MONOTONIC;
  if (age(std::chrono::system_clock::now()) < 10000000000) return ODOM_CLOCK_REALTIME;
  fail(source, "its driver does not stamp pictures with the monotonic or the real time");
}

}  // namespace

int main(int argc, char** argv) try {
  std::string tags, lens, source, socket;
  double start = 0.0, sighted = 0.0;
  bool live = false;
  CLI::App app{
      "Sends the car's pose to odomd, from AprilTags in a camera's pictures. Prints the poses as\n"
      "odom replay --camera reads them; those of a film are only printed, except with --live.\n"
      "Example: apriltag_camera --tags tags.toml --lens lens.yaml /dev/video0"};
  app.add_option("--tags", tags, "as in docs/camera.md")->required()->check(CLI::ExistingFile);
  app.add_option("--lens", lens, "calibration by OpenCV")->required()->check(CLI::ExistingFile);
  app.add_option("source", source, "camera or film")->required()->check(CLI::ExistingPath);
  app.add_option("--start", start, "begin of the film on the log's clock [s]");
  app.add_flag("--live", live, "play the film as if it were being taken")->excludes("--start");
  app.add_option("--socket", socket, "odomd's camera socket");
  CLI11_PARSE(app, argc, argv);
  const Setup setup = read_setup(tags, lens);
  const bool film = std::filesystem::is_regular_file(source), sending = live || !film;
  odom::CameraSender sender;
  int error = sending ? sender.open(socket.empty() ? nullptr : socket.c_str()) : 0;
  if (error != 0) fail(socket.empty() ? "odomd's camera socket" : socket, std::strerror(-error));
  cv::VideoCapture capture(source, film ? cv::CAP_FFMPEG : cv::CAP_V4L2);
  if (!capture.isOpened())
    fail(source, film ? "cannot be read as a film" : "is not a camera, is in use or forbidden");
  capture.set(cv::CAP_PROP_FRAME_WIDTH, setup.picture.width);  // has no effect on a film
  capture.set(cv::CAP_PROP_FRAME_HEIGHT, setup.picture.height);
  std::fprintf(stderr, "%s: %g x %g pixels, %.2f pictures/s\n", source.c_str(),
               capture.get(cv::CAP_PROP_FRAME_WIDTH), capture.get(cv::CAP_PROP_FRAME_HEIGHT),
               capture.get(cv::CAP_PROP_FPS));
  std::int64_t origin_ns = std::llround(1e9 * start);
  if (sending) origin_ns = film ? steady_clock::now().time_since_epoch().count() : 0;
  int pictures = 0, poses = 0;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::puts("t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw");
  for (cv::Mat picture, grey; capture.read(picture); ++pictures) {
    if (picture.size() != setup.picture)
      fail(source, "its pictures are not of the size in " + lens);
    std::int64_t t_ns = origin_ns + std::llround(1e6 * capture.get(cv::CAP_PROP_POS_MSEC));
    if (film && live)
      std::this_thread::sleep_until(steady_clock::time_point(std::chrono::nanoseconds(t_ns)));
    const odom_clock clock = film ? ODOM_CLOCK_MONOTONIC : clock_of(t_ns, source);
    t_ns += std::llround(1e9 * setup.stamp_offset);
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    const std::vector<Sighting> seen = find_tags(setup, grey);
    const double t = 1e-9 * static_cast<double>(t_ns);
    if (pictures == 0 || !seen.empty()) sighted = t;
    if (t - sighted > 2.0)  // reported once
      std::fprintf(stderr, "no known tag since %.3f s\n", std::exchange(sighted, INFINITY));
    if (seen.empty()) continue;
    const std::optional<cv::Vec6d> pose = estimate(setup, seen);
    if (!pose) std::fprintf(stderr, "%.3f s: tags are not where %s says\n", t, tags.c_str());
    if (!pose) continue;
    const cv::Vec6d& p = *pose;
    std::printf("%.6f,%.6f,%.5f,%.5f,%.6f", t, t, p[0], p[1], p[2]);
    std::printf(",%.5f,%.5f,%.6f\n", p[3], p[4], p[5]);
    const odom::CameraMessage message{
        0, 0, static_cast<std::uint16_t>(clock), 0, t_ns, p[0], p[1], p[2], p[3], p[4], p[5], 0};
    ++poses;
    const int before = std::exchange(error, sending ? sender.send(message) : 0);
    if (error != before && error != 0)
      std::fprintf(stderr, "odomd's camera socket: %s\n", std::strerror(-error));
  }
  std::fprintf(stderr, "%s: %d pictures, %d poses\n", source.c_str(), pictures, poses);
  if (!film) fail(source, "no more pictures; is it still connected?");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "apriltag_camera: %s\n", error.what());
  return 2;
}
