// A path-following controller that uses odomd's pose, in C++. Shows what to check before steering.
//
//   stanley_cpp --path FILE [--shm NAME] [--cycles N] [--delay S] [--speed V]
//               [--max-sigma M] [--max-sigma-yaw RAD]
//
// For each pose it prints one command:
//   tick,state,steering,speed,cross_track,reset_count,instance        [rad, m/s, m]
// A car would send steering and speed to its actuators instead. The path is a CSV file with the
// columns x and y and, optionally, speed or vx, such as truth.csv of `odom sim`.
//
// Stanley's law steers the front axle onto the path. It uses the pose predicted to the time at
// which the steering will have moved:  steering = heading error - atan(gain * cross_track / speed).
#include <getopt.h>

#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <odom/odom.hpp>

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double gain = 2.0;           // 1/s
constexpr double softening = 0.5;      // m/s, added to the speed: smoother steering when slow
constexpr double max_steering = 0.4;   // rad
constexpr double max_distance = 1.0;   // m from the path; above it, the car is lost
constexpr double min_spacing = 0.02;   // m between points
constexpr double closing_gap = 0.5;    // m from end to start; below it, the path is a loop
constexpr double degraded_part = 0.5;  // fraction of the speed while the pose is degraded
// Stop above these sigmas: the car may have left its lane.
constexpr double lane_sigma = 0.3;      // m, --max-sigma: the lane has 3 sigma on each side
constexpr double lane_sigma_yaw = 0.2;  // rad, --max-sigma-yaw
constexpr int points_behind = 10;       // of the path, searched in every cycle
constexpr int points_ahead = 50;

struct Point {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  double speed = 0.0;
};

struct Path {
  std::vector<Point> points;
  bool closed = false;
};

struct Command {
  const char* state = "silent";  // all zero: stops if there is no fresh pose
  double steering = 0.0;
  double speed = 0.0;
  double cross_track = 0.0;
};

double distance(const Point& a, const Point& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> result;
  std::istringstream text(line);
  for (std::string field; std::getline(text, field, ',');)
    result.push_back(field.substr(0, field.find('\r')));
  return result;
}

// Leaves out rows of a stationary car, and rows too close to the one before.
Path read_path(const std::string& name, double speed) {
  std::ifstream file(name);
  std::string line;
  if (!std::getline(file, line)) throw std::invalid_argument(name + ": cannot be read");
  const std::vector<std::string> header = fields(line);
  const auto column = [&](const char* wanted) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), wanted) -
                                    header.begin());
  };
  const std::size_t x = column("x");
  const std::size_t y = column("y");
  const std::size_t v = column("speed") < header.size() ? column("speed") : column("vx");
  if (x == header.size() || y == header.size())
    throw std::invalid_argument(name + ": the first line has no columns x and y");

  Path path;
  while (std::getline(file, line)) {
    const std::vector<std::string> row = fields(line);
    const auto number = [&](std::size_t index) {
      char* end = nullptr;
      const double value = index < row.size() ? std::strtod(row[index].c_str(), &end) : 0.0;
      if (end == nullptr || end == row[index].c_str() || !std::isfinite(value))
        throw std::invalid_argument(name + ": a row lacks a number");
      return value;
    };
    const Point p{number(x), number(y), 0.0, v == header.size() ? speed : number(v)};
    if (p.speed < 0.1) continue;
    if (path.points.empty() || distance(p, path.points.back()) >= min_spacing)
      path.points.push_back(p);
  }
  if (path.points.size() < 2) throw std::invalid_argument(name + ": a path needs two points");

  path.closed = distance(path.points.front(), path.points.back()) < closing_gap;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Point& p = path.points[i];
    const Point& next = path.points[i + 1];
    path.points[i].yaw = std::atan2(next.y - p.y, next.x - p.x);
  }
  path.points.back().yaw = path.points[path.points.size() - 2].yaw;
  return path;
}

// The point of the path nearest to `at`: searched around `last`, or everywhere if `last` < 0.
int nearest(const Path& path, const Point& at, int last) {
  const int count = static_cast<int>(path.points.size());
  const bool anywhere = last < 0 || count <= points_behind + points_ahead;
  const int first = anywhere ? 0 : last - points_behind;
  const int end = anywhere ? count : last + points_ahead;
  int best = last < 0 ? 0 : last;
  double best_distance = std::numeric_limits<double>::infinity();
  for (int i = first; i < end; ++i) {
    if (!path.closed && (i < 0 || i >= count)) continue;
    const int index = (i + count) % count;
    const double d = distance(path.points[static_cast<std::size_t>(index)], at);
    if (d < best_distance) {
      best = index;
      best_distance = d;
    }
  }
  return best;
}

Command follow(const Path& path, int& last, const odom::Pose& pose, double front_axle) {
  const Point front{pose.x + front_axle * std::cos(pose.yaw),
                    pose.y + front_axle * std::sin(pose.yaw), pose.yaw, pose.vx};
  last = nearest(path, front, last);
  const Point& p = path.points[static_cast<std::size_t>(last)];
  if (!path.closed && &p == &path.points.back()) return {"arrived"};
  if (!(distance(p, front) <= max_distance)) return {"lost"};

  // Positive if the front axle is to the left of the path.
  const double cross_track = std::cos(p.yaw) * (front.y - p.y) - std::sin(p.yaw) * (front.x - p.x);
  const double heading_error = std::remainder(p.yaw - front.yaw, 2.0 * pi);
  const double steering =
      std::clamp(heading_error - std::atan2(gain * cross_track, softening + std::abs(front.speed)),
                 -max_steering, max_steering);
  if (pose.mode == ODOM_DEGRADED)  // a condition bit shows why: drive carefully
    return {"degraded", steering, degraded_part * p.speed, cross_track};
  return {"drive", steering, p.speed, cross_track};
}

odom::Client open_client(const char* name) {  // the daemon may start later
  for (;;) {
    auto client = odom::Client::open(name);
    if (client) return std::move(*client);
    std::fprintf(stderr, "stanley: waiting: %s\n", client.message());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const option options[] = {{"path", required_argument, nullptr, 'p'},
                            {"shm", required_argument, nullptr, 's'},
                            {"cycles", required_argument, nullptr, 'c'},
                            {"delay", required_argument, nullptr, 'd'},
                            {"speed", required_argument, nullptr, 'v'},
                            {"max-sigma", required_argument, nullptr, 'm'},
                            {"max-sigma-yaw", required_argument, nullptr, 'y'},
                            {nullptr, 0, nullptr, 0}};
  const char* path_name = nullptr;
  const char* shm = nullptr;
  long cycles = -1;     // no limit
  double delay = 0.02;  // s, from the pose to steering motion
  double speed = 1.0;   // m/s, if the path has no speed
  double max_sigma = lane_sigma;
  double max_sigma_yaw = lane_sigma_yaw;
  for (int key = 0; (key = getopt_long(argc, argv, "", options, nullptr)) != -1;) {
    if (key == 'p') path_name = optarg;
    if (key == 's') shm = optarg;
    if (key == 'c') cycles = std::strtol(optarg, nullptr, 10);
    if (key == 'd') delay = std::strtod(optarg, nullptr);
    if (key == 'v') speed = std::strtod(optarg, nullptr);
    if (key == 'm') max_sigma = std::strtod(optarg, nullptr);
    if (key == 'y') max_sigma_yaw = std::strtod(optarg, nullptr);
    if (key == '?') return 2;
  }
  if (path_name == nullptr || optind != argc)
    throw std::invalid_argument("usage: --path FILE is needed");
  const Path path = read_path(path_name, speed);
  const auto delay_ns = static_cast<std::int64_t>(delay * 1e9);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);

  odom::Client client = open_client(shm);
  odom::Info info = *client.info();
  odom::Pose pose{};
  int last = -1;  // index on the path; -1: unknown
  std::puts("tick,state,steering,speed,cross_track,reset_count,instance");
  for (; cycles != 0; cycles -= cycles > 0 ? 1 : 0) {
    const odom::Info before = info;
    const std::uint32_t resets = pose.reset_count;
    const auto fresh = client.wait(pose, std::chrono::nanoseconds(10 * info.period_ns));
    if (fresh.has_value()) pose = *fresh;
    info = *client.info();
    // After a restart or a jump of the map pose, the car may be anywhere along the path.
    if (info.instance_id != before.instance_id || pose.reset_count != resets) last = -1;

    Command command;
    if (!fresh) {
      last = -1;  // stale, timed out or no pose yet; the client re-attaches by itself
    } else if (pose.mode == ODOM_INITIALISING || pose.mode == ODOM_FAULT) {
      command.state = odom::mode_name(pose.mode);
    } else if (const auto ahead = odom::predict(pose, pose.time_ns + delay_ns); !ahead) {
      command.state = "unpredictable";  // the delay is longer than 100 ms
    } else if (!(odom::position_sigma(*ahead) <= max_sigma &&
                 std::sqrt(ahead->covariance[5]) <= max_sigma_yaw)) {
      command.state = "uncertain";  // in any mode
      last = -1;
    } else {
      command = follow(path, last, *ahead, info.front_axle);
    }
    std::printf("%" PRIu64 ",%s,%.4f,%.4f,%.4f,%" PRIu32 ",%016" PRIx64 "\n", pose.tick,
                command.state, command.steering, command.speed, command.cross_track,
                pose.reset_count, info.instance_id);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "stanley: %s\n", error.what());
  return 2;
}
