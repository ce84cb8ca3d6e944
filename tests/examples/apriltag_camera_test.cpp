// The AprilTag camera, on films rendered with lens distortion, blur and noise.
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <sys/socket.h>

#include <chrono>
#include <odom/odom.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "tests/tools/scratch.hpp"
#include "tests/unix_socket.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/marker_tracking/film.hpp"
#include "tools/marker_tracking/film_renderer.hpp"

namespace odomd::tools::apriltag_test {
namespace {

using estimator::CameraPose;
using Scene = std::vector<FlatPicture>;
using Car = cv::Vec3d;  // x, y [m], yaw [deg]
constexpr double degree = CV_PI / 180.0;
constexpr double rate = 25.0;
const FilmCamera seeing{.picture = {640, 960}, .focal = 680.0};

cv::Vec2d moved(const Car& car, double x, double y) {
  const double c = std::cos(car[2] * degree), s = std::sin(car[2] * degree);
  return {car[0] + c * x - s * y, car[1] + s * x + c * y};
}

/// 10 x 10 cells, including the tag's 8 x 8.
FlatPicture picture_of(int id, double size, bool damaged = false) {
  apriltag_family_t* family = tag36h11_create();
  image_u8_t* image = apriltag_to_image(family, id);
  cv::Mat cells(image->height, image->width, CV_8U, image->buf,
                static_cast<std::size_t>(image->stride));
  if (damaged) cells.at<uchar>(3, 4) ^= 255;
  cv::Mat colour, large;
  cv::cvtColor(cells, colour, cv::COLOR_GRAY2BGR);
  cv::resize(colour, large, {}, 16, 16, cv::INTER_NEAREST);
  image_u8_destroy(image);
  tag36h11_destroy(family);
  return {large, size * 10 / 8};
}

// The renderer's ground plane serves as a wall that faces -x: its axes are -y, z and -x of the map.
FlatPicture on_wall(int id, double x, double y, double z, bool damaged = false) {
  const FlatPicture flat = picture_of(id, 0.16, damaged);
  return {flat.image, flat.side, -y, z, 90 * degree, -x};
}

cv::Mat from(const cv::Vec3d& place, double tilt_deg, double heading_deg, const Scene& scene) {
  static std::uint64_t seed = 0;
  const FilmCamera camera{seeing.picture, seeing.focal,      seeing.distortion,
                          place,          tilt_deg * degree, heading_deg * degree};
  return FilmRenderer(camera, 3.0, ++seed).render(scene);
}

cv::Mat from_car(const Car& car, const Scene& scene) {
  const cv::Vec2d eye = moved(car, 0.2, 0.0);
  return from({-eye[1], 0.15, -eye[0]}, -car[2], 0.0, scene);
}

const std::string two_tags = R"(camera = {on_car=true, x=0.2, y=0.0, z=0.15, roll_deg=90}
tag = [{id=0, size=0.16, x=2.0, y=0.0, z=0.2, yaw_deg=180},
       {id=1, size=0.16, x=1.5, y=0.5, z=0.1, yaw_deg=180}])";
const FlatPicture front = on_wall(0, 2.0, 0.0, 0.2), left = on_wall(1, 1.5, 0.5, 0.1);
const std::vector<Car> cars{{0.3, 0.0, 0}, {0.3, 0.1, 5},   {0.2, 0.3, 0},   {0.4, -0.3, 20},
                            {0.3, 0.7, 0}, {0.1, -0.3, 25}, {-0.1, 0.6, -15}};

std::vector<cv::Mat> from_cars(const Scene& scene) {
  std::vector<cv::Mat> pictures;
  for (const Car& car : cars) pictures.push_back(from_car(car, scene));
  return pictures;
}

std::string with_keys(std::string toml, const std::string& keys) {
  return toml.insert(toml.find('}'), ", " + keys);
}

/// Errors of x, y and yaw, then the same errors divided by their sigmas.
cv::Vec6d errors_of(const CameraPose& pose, const Car& car) {
  const double x = pose.x - car[0], y = pose.y - car[1];
  const double yaw = std::remainder(pose.yaw - car[2] * degree, 2 * CV_PI);
  return {x, y, yaw, x / pose.sigma_x, y / pose.sigma_y, yaw / pose.sigma_yaw};
}

class AprilTagCamera : public ::testing::Test {
 protected:
  AprilTagCamera() {
    const Lens lens{
        .matrix = seeing.matrix(), .distortion = seeing.distortion, .picture = seeing.picture};
    write_lens(scratch_.path("lens.yaml"), lens);
  }

  [[nodiscard]] Outcome run(const std::string& tags, const std::string& options = "") const {
    scratch_.write("tags.toml", tags);
    return run_shell("cd " + scratch_.path("").string() +
                     " && " ODOMD_BIN_DIR
                     "/examples/apriltag_camera --tags tags.toml --lens lens.yaml film.avi " +
                     options);
  }

  [[nodiscard]] std::vector<CameraPose> poses(const std::vector<cv::Mat>& pictures,
                                              const std::string& tags,
                                              const std::string& options = "") {
    cv::VideoWriter video = open_video(scratch_.path("film.avi"), rate, seeing.picture);
    for (const cv::Mat& picture : pictures) video.write(picture);
    video.release();
    outcome_ = run(tags, options);
    EXPECT_EQ(outcome_.status, 0) << outcome_.err;
    std::istringstream out(outcome_.out);
    CsvReader reader = camera_reader(out, "out");
    std::vector<CameraPose> found;
    while (const auto pose = next_camera_pose(reader)) found.push_back(*pose);
    return found;
  }

  Scratch scratch_;
  Outcome outcome_;
};

void expect_near(const std::vector<CameraPose>& poses, const std::vector<Car>& truth,
                 double start) {
  ASSERT_EQ(poses.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double t = start + static_cast<double>(i) / rate;
    EXPECT_NEAR(static_cast<double>(poses[i].capture_ns), 1e9 * t, 5e6);
    const cv::Vec6d error = errors_of(poses[i], truth[i]);
    EXPECT_LT(std::hypot(error[0], error[1]), 0.01) << i;
    EXPECT_LT(std::abs(error[2]), 0.5 * degree) << i;
    for (int k = 3; k < 6; ++k) EXPECT_LT(std::abs(error[k]), 4.0) << i << ' ' << k;
  }
}

// The camera is 1.5 m above a tag on the roof.
TEST_F(AprilTagCamera, FollowsATagOnTheCar) {
  const std::vector<Car> truth{{1, 2, 0},       {1.3, 2.3, 45},  {0.6, 1.8, 90},  {1.2, 1.6, 137},
                               {0.6, 2.4, 180}, {1.6, 1.9, -90}, {0.9, 2.4, -20}, {1.3, 2.2, -165}};
  std::vector<cv::Mat> pictures;
  const FlatPicture roof = picture_of(7, 0.1);
  for (const Car& car : truth) {
    const cv::Vec2d at = moved(car, -0.05, 0.02);
    pictures.push_back(from({1.0, 2.0, 1.7}, 10, 30,
                            {{roof.image, roof.side, at[0], at[1], car[2] * degree, 0.2}}));
  }
  const std::string tags = R"(
camera = {on_car=false, x=1.0, y=2.0, z=1.7, pitch_deg=80, yaw_deg=30}
tag = [{id=7, size=0.1, x=-0.05, y=0.02, z=0.2, pitch_deg=-90, yaw_deg=180}])";
  expect_near(poses(pictures, tags, "--start 100.5"), truth, 100.5);
}

TEST_F(AprilTagCamera, FollowsTagsOfTheMap) {
  expect_near(poses(from_cars({front, left}), two_tags), cars, 0.0);
}

// Seen from the front, two poses fit a tag almost equally well. The tags are docs/camera.md's.
TEST_F(AprilTagCamera, SigmasCoverBothPosesOfASingleTag) {
  std::string toml = contents(ODOMD_SOURCE_DIR "/docs/camera.md");
  toml = toml.substr(toml.find("```toml\n") + 8);
  toml = with_keys(toml.substr(0, toml.find("```")), "roll_deg=90");
  const std::vector<cv::Mat> pictures = from_cars({front});
  const auto wide = poses(pictures, toml);
  // With this noise in the pictures and exact positions, the sigmas match the errors.
  toml = with_keys(toml, "sigma_corner=0.06, sigma_tag=0.0001, sigma_tag_deg=0.01");
  const auto exact = poses(pictures, with_keys(toml, "sigma_z=0.0001, sigma_tilt_deg=0.01"));
  ASSERT_EQ(wide.size(), cars.size());
  ASSERT_EQ(exact.size(), cars.size());
  EXPECT_GT(wide[0].sigma_y, 0.05);
  double nees = 0.0;
  for (std::size_t i = 0; i < cars.size(); ++i)
    for (int k = 3; k < 6; ++k) {
      EXPECT_LT(std::abs(errors_of(wide[i], cars[i])[k]), 3.0);
      nees += std::pow(errors_of(exact[i], cars[i])[k], 2) / 21.0;
    }
  EXPECT_GT(nees, 0.2);
  EXPECT_LT(nees, 3.0);
}

TEST_F(AprilTagCamera, SkipsWhatIsNotATagOfTheFile) {
  const Car car{0.3, 0.1, 5}, turned{0.3, 0.1, 33};  // half of a tag is visible
  const std::vector<cv::Mat> pictures{from_car(car, {on_wall(5, 1.5, 0.5, 0.1)}),
                                      from_car(car, {}),
                                      from_car(turned, {front}),
                                      from_car(car, {on_wall(1, 1.5, 0.5, 0.1, true)}),
                                      from_car(car, {front, on_wall(1, 1.6, 0.5, 0.1)}),
                                      from_car(car, {front, left})};
  const auto found = poses(pictures, two_tags);
  EXPECT_THAT(outcome_.err,
              AllOf(HasSubstr("0.160 s: tags are not where"), HasSubstr("6 pictures, 1 ")));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(static_cast<double>(found[0].capture_ns), 5e9 / rate, 5e6);
  const auto tolerant = poses(pictures, with_keys(two_tags, "max_hamming=1"));
  ASSERT_EQ(tolerant.size(), 2U);
  EXPECT_NEAR(static_cast<double>(tolerant[0].capture_ns), 3e9 / rate, 5e6);
}

TEST_F(AprilTagCamera, SendsALiveFilm) {
  const std::string toml = with_keys(two_tags, "stamp_offset=-0.03");
  const std::vector<cv::Mat> pictures(4, from_car(cars[0], {front, left}));
  const FileDescriptor door = listening_socket(scratch_.path("socket"), SOCK_SEQPACKET);
  std::thread camera(
      [&] { EXPECT_EQ(poses(pictures, toml, "--live --socket socket").size(), pictures.size()); });
  const FileDescriptor connection(::accept(door.get(), nullptr, nullptr));
  std::vector<odom_camera_message> sent;
  for (odom_camera_message m{}; ::recv(connection.get(), &m, sizeof m, 0) == sizeof m;) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    EXPECT_LT(std::chrono::nanoseconds(m.capture_ns), now - std::chrono::milliseconds(30));
    EXPECT_EQ(m.clock, ODOM_CLOCK_MONOTONIC);
    EXPECT_NEAR(m.x, cars[0][0], 0.01);
    sent.push_back(m);
    EXPECT_NEAR(static_cast<double>(m.capture_ns - sent[0].capture_ns),
                1e9 * static_cast<double>(m.sequence - 1) / rate, 5e6);
  }
  camera.join();
  EXPECT_EQ(sent.size(), pictures.size());
  EXPECT_THAT(run(toml, "--live --socket none"), Ends(2, HasSubstr("none: No such file")));
}

TEST_F(AprilTagCamera, NamesFileLineAndKeyOfAMistake) {
  const std::string camera = "camera = {on_car=true, x=0, y=0, z=0}\n";
  const std::string tag = "tag = [{id=0, size=0.1, x=0, y=0, z=0}]\n";
  EXPECT_TRUE(poses({cv::Mat(seeing.picture, CV_8UC3, cv::Scalar())}, camera + tag).empty());
  const std::vector<std::pair<std::string, std::string>> mistakes{
      {"camera = {", "1: "},
      {tag, "1: camera is missing: a table [camera]"},
      {camera + "tag = [1]", "2: tag is wrong: a table [[tag]] for each"},
      {camera + tag + "family = 3", "3: family is wrong: docs/camera.md has no such key"},
      {"[camera]\non_car = 1\n", "2: [camera] on_car is wrong: true or false"},
      {"[camera]\non_car = true\nx = \"1\"\n", "3: [camera] x is wrong: a number"},
      {"[camera]\non_car=true\nx=0\ny=0\nz=0\nsigma_z=0\n", "6: [camera] sigma_z is wrong"},
      {camera + "[[tag]]\nid=1.5", "3: [[tag]] id is wrong: a whole number"},
      {camera + "[[tag]]\nid=1\nx=nan\ny=0\nz=0", "2: [[tag]] size is missing"},
      {camera + "tag = [{id=0, size=1, x=0, y=0, z=0}, {id=0}]", "2: [[tag]] id is wrong"}};
  for (const auto& [text, message] : mistakes)
    EXPECT_THAT(run(text), Ends(2, HasSubstr("tags.toml:" + message))) << text;
  scratch_.write("film.avi", "no film");
  EXPECT_THAT(run(camera + tag), Ends(2, HasSubstr("film.avi: cannot be read as a film")));
  scratch_.write("lens.yaml", "%YAML:1.0\nimage_width: 640\n");
  EXPECT_THAT(run(camera + tag), Ends(2, HasSubstr("lens.yaml: camera_matrix, distortion_")));
  scratch_.write("lens.yaml", "image_width: 640\n");
  EXPECT_THAT(run(camera + tag), Ends(2, HasSubstr("lens.yaml: is not a calibration")));
}

}  // namespace
}  // namespace odomd::tools::apriltag_test
