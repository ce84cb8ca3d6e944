// odom camera send: camera poses to the running daemon, by hand, from a log or from a pipe.
#include <cmath>

#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/live/daemon_feeds.hpp"
#include "tools/live/daemon_link.hpp"

namespace odomd::tools {
namespace {

struct CameraOptions {
  std::string socket;
  std::string shm;
  std::vector<double> pose;
  std::vector<double> sigma{0.01, 0.01, 0.01};
  double age_ms = 0.0;
  std::string log;
  bool from_now = false;
  std::optional<odom_clock> clock;  // none: monotonic
  double wait_s = 0.0;
};

void send_one(const CameraOptions& options) {
  constexpr double ns_per_ms = 1e6;
  if (!std::ranges::all_of(options.pose, [](double value) { return std::isfinite(value); }))
    throw std::invalid_argument("--pose: must be three finite numbers");
  CameraFeed feed{options.socket, options.wait_s};
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  estimator::CameraPose pose;
  pose.capture_ns =
      std::chrono::nanoseconds{now}.count() - std::llround(options.age_ms * ns_per_ms);
  pose.x = options.pose[0];
  pose.y = options.pose[1];
  pose.yaw = options.pose[2];
  pose.sigma_x = options.sigma[0];
  pose.sigma_y = options.sigma[1];
  pose.sigma_yaw = options.sigma[2];
  if (!feed.send(pose, ODOM_CLOCK_MONOTONIC)) {
    throw std::runtime_error(feed.refusal().empty()
                                 ? feed.socket() + ": the daemon closed the connection"
                                 : feed.refusal());
  }
}

// Reports poses that were not sent; a refusal is an error even if others were sent.
void report_untaken(const CameraFeed& feed, std::uint64_t untaken) {
  if (!feed.refusal().empty())
    throw std::runtime_error(feed.refusal() + " (" + std::to_string(untaken) +
                             " poses were not taken)");
  if (untaken > 0) warn("camera send", std::to_string(untaken) + " poses found no daemon");
}

void send_log(const CameraOptions& options) {
  if (options.clock.value_or(ODOM_CLOCK_LOG) != ODOM_CLOCK_LOG) {
    throw std::invalid_argument(
        "--clock: a --log is on the log's clock; use --clock log, or --from-now");
  }
  const CameraLog log = read_camera_log(options.log);
  warn("camera send", log.warnings);
  CameraFeed feed{options.socket, options.wait_s};
  PlayedLog played;
  if (options.from_now) {
    played = play_from_now(feed, log.poses);
  } else {
    if (!options.socket.empty() && options.shm.empty() && std::getenv("ODOM_SHM") == nullptr)
      throw std::invalid_argument("--socket: give the segment of that daemon with --shm");
    odom::Client client = attach(options.shm, options.wait_s);
    played = play_with_daemon(feed, client, log.poses, options.wait_s);
  }
  if (played.daemon_ended) warn("camera send", "the daemon ended before the log did");
  if (played.late > 0) {
    warn("camera send", std::to_string(played.late) + " poses were due before the start; left out");
  }
  std::cerr << "odom camera send: " << played.sent << " of " << log.poses.size() << " poses sent\n";
  report_untaken(feed, played.refused);
  if (played.sent == 0 && !log.poses.empty()) throw std::runtime_error("no pose was sent");
}

// Sends rows as they arrive, such as those of another camera program through a pipe.
void send_rows(const CameraOptions& options) {
  CsvReader reader = camera_reader(std::cin, "standard input");
  CameraFeed feed{options.socket, options.wait_s};
  std::uint64_t sent = 0;
  std::uint64_t refused = 0;
  while (const auto pose = next_camera_pose(reader)) {
    const bool taken = feed.send(*pose, options.clock.value_or(ODOM_CLOCK_MONOTONIC));
    ++(taken ? sent : refused);
  }
  for (const auto& text : reader.warnings()) warn("camera send", text);
  std::cerr << "odom camera send: " << sent << " poses sent\n";
  report_untaken(feed, refused);
  if (sent == 0 && refused > 0) throw std::runtime_error("no pose was sent");
}

}  // namespace

void add_camera(Command odom) {
  auto options = std::make_shared<CameraOptions>();
  Command camera =
      odom.add_subcommand("camera", "Send camera poses to the daemon, from a file or one by one");
  camera.require_subcommand();
  camera.footer(
      "Example:\n"
      "  odom camera send --pose 1.2,0.4,1.57\n"
      "odom camera send --help has more.");
  Command command = camera.add_subcommand("send", "Send camera poses to the daemon");
  add_socket_option(command, options->socket, "camera");
  add_wait_option(command, options->wait_s);
  command.add("--pose", "X,Y,YAW", options->pose, "One pose of the reference point [m, m, rad]",
              {delimiter(','), values(3)});
  command.add("--sigma", "SX,SY,SYAW", options->sigma,
              "Standard uncertainty of the pose [m, m, rad]; default: 0.01 each",
              {delimiter(','), values(3), positive(), needs("--pose")});
  command.add("--age-ms", "MS", options->age_ms,
              "Age of the pose: time since the picture was taken [ms]; default: 0",
              {within(-1e9, 1e9, Bounds::in_text), needs("--pose")});
  command.add("--log", "CSV", options->log,
              "Camera log, sent in step with the log that the daemon replays",
              {excludes("--pose")});
  command.add_flag("--from-now", options->from_now, "Replay the log by itself, starting now",
                   {needs("--log")});
  add_segment_option(command, options->shm, SegmentElse::default_names, {needs("--log")});
  command.add_choice("--clock", options->clock,
                     {{"monotonic", ODOM_CLOCK_MONOTONIC},
                      {"realtime", ODOM_CLOCK_REALTIME},
                      {"log", ODOM_CLOCK_LOG}},
                     "Clock of t_capture in rows from standard input; "
                     "default: monotonic. A --log is on the log's clock",
                     {excludes("--pose")});
  command.footer(
      "Examples:\n"
      "  odom camera send --pose 1.2,0.4,1.57 --sigma 0.01,0.01,0.01 --age-ms 40\n"
      "  odom camera send --log camera.csv --wait 10\n"
      "  my_camera | odom camera send --clock realtime\n"
      "Without --pose and --log, rows of t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n"
      "(with this header) are read from standard input and sent as they arrive. A --log is\n"
      "paced by the daemon's log clock, which is read from its segment (--shm); --from-now does\n"
      "not need it.");
  command.callback([options] {
    const auto send = !options->pose.empty()  ? send_one
                      : !options->log.empty() ? send_log
                                              : send_rows;
    send(*options);
  });
}

}  // namespace odomd::tools
