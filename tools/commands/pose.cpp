// odom pose: the pose from shared memory, once or at every tick.
#include <cmath>

#include "daemon/core/conditions.hpp"
#include "tools/cli/csv.hpp"
#include "tools/commands/commands.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/tick_follower.hpp"
#include "tools/live/watch/page.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

struct PoseOptions {
  std::string shm;
  bool json = false;
  bool follow = false;
  bool csv = false;
  odom_clock clock = ODOM_CLOCK_MONOTONIC;
  double wait_s = 0.0;
  bool until_stale = false;
};

const Choices<odom_clock>& clocks() {
  static const Choices<odom_clock> names{{"monotonic", ODOM_CLOCK_MONOTONIC},
                                         {"realtime", ODOM_CLOCK_REALTIME},
                                         {"log", ODOM_CLOCK_LOG}};
  return names;
}

constexpr const char* no_log = "the daemon is not playing a log; use --clock monotonic or realtime";

// One JSON object and a newline. `t_ns` is the pose's time on the requested clock.
std::string as_json(const odom_pose& pose, std::int64_t age_ns, odom_clock clock, std::int64_t t_ns,
                    bool fresh) {
  const auto sigma = [&pose](std::size_t diagonal) {
    return std::sqrt(std::max(0.0, pose.covariance[diagonal]));
  };
  const nlohmann::ordered_json json{
      {"fresh", fresh},
      {"tick", pose.tick},
      {"clock",
       std::ranges::find(clocks(), clock, &Choices<odom_clock>::value_type::second)->first},
      {"time_ns", t_ns},
      {"age_s", static_cast<double>(age_ns) / 1e9},
      {"mode", mode_name(pose.mode)},
      {"conditions", daemon::condition_names(pose.conditions)},
      {"x", pose.x},
      {"y", pose.y},
      {"yaw", pose.yaw},
      {"sigma_x", sigma(0)},
      {"sigma_y", sigma(3)},
      {"sigma_yaw", sigma(5)},
      {"odom_x", pose.odom_x},
      {"odom_y", pose.odom_y},
      {"odom_yaw", pose.odom_yaw},
      {"vx", pose.vx},
      {"vy", pose.vy},
      {"yaw_rate", pose.yaw_rate},
      {"steering", pose.steering},
      {"accel_x", pose.accel_x},
      {"accel_y", pose.accel_y},
      {"reset_count", pose.reset_count},
      {"last_jump", {pose.jump_x, pose.jump_y, pose.jump_yaw}}};
  return json.dump(2) + '\n';
}

void print_once(const PoseOptions& options, odom::Client& client) {
  const auto latest = client.latest_details();
  if (!latest.has_value()) throw std::runtime_error(latest.message());
  const odom_pose& pose = latest->pose;
  const auto t = client.to_clock(options.clock, pose.time_ns);
  if (!t.has_value()) throw std::runtime_error(no_log);
  const std::int64_t now_ns = steady_clock::now().time_since_epoch() / std::chrono::nanoseconds{1};
  const std::int64_t age_ns = now_ns - pose.time_ns;
  const bool fresh = latest.status == ODOM_OK;
  if (options.json) {
    std::cout << as_json(pose, age_ns, options.clock, *t, fresh);
  } else {
    watch::State state{.now_ns = now_ns};
    state.segment = watch::Segment{.pose = pose, .details = latest->details};
    std::cout << as_text(watch::mode_lines(state, 100))
              << as_text(watch::pose_section(state, 100, 0));
  }
  if (!fresh)
    throw std::runtime_error("the daemon has stopped publishing: this was its last pose, " +
                             fixed(static_cast<double>(age_ns) * 1e-9, 1) + " s ago");
}

std::string as_line(const odom_pose& pose, std::int64_t t_ns) {
  std::string time;
  append_seconds(time, t_ns);
  const double heading = degrees * std::remainder(pose.yaw, 2.0 * std::numbers::pi);
  return fmt::format("{:>20}  x {:>9}  y {:>9}  yaw {:>7} deg  v {:>6} m/s  {}\n", time,
                     fixed(pose.x, 3), fixed(pose.y, 3), fixed(heading, 1), fixed(pose.vx, 2),
                     mode_name(pose.mode));
}

void follow(const PoseOptions& options, odom::Client client) {
  // A short delay of the daemon does not count as its end.
  const std::chrono::milliseconds timeout{options.until_stale ? 500 : 100};
  constexpr double people_hz = 5.0;
  const auto info = client.info();
  TickFollower follower{std::move(client)};
  std::uint64_t every = 1, rows = 0, untimed = 0;  // untimed: before the log's clock was known
  if (!options.csv && info.has_value())
    every = static_cast<std::uint64_t>(
        std::max(std::llround(1e9 / (people_hz * static_cast<double>(info->period_ns))), 1LL));
  std::string text = options.csv ? pose_header() : "";
  const auto take = [&](const odom_pose& pose) {
    if (pose.mode == ODOM_INITIALISING || pose.tick % every != 0) return;
    const auto t = follower.client().to_clock(options.clock, pose.time_ns);
    ++(t.has_value() ? rows : untimed);
    if (!t.has_value()) return;
    if (options.csv)
      append_pose_row(text, pose, *t);
    else
      text += as_line(pose, *t);
  };
  Interrupt interrupt;
  const auto start = steady_clock::now();
  // Each batch is flushed for a reader that follows.
  while (std::cout << std::exchange(text, {}) << std::flush && !interrupt.requested()) {
    const auto status = follower.follow(timeout, take);
    if (status == ODOM_STALE && options.until_stale) break;
    if (follower.falls_silent(status))
      std::cerr << "odom pose: the daemon has stopped publishing; waiting for it\n";
  }
  std::cout << text;
  if (rows == 0 && untimed > 0) throw std::runtime_error(no_log);
  const FollowCounts& counts = follower.counts();
  const std::chrono::duration<double> elapsed = steady_clock::now() - start;
  std::cerr << fmt::format(
      "odom pose: {} ticks in {} s, {} rows; {} missed by the daemon, {} fetched from the history, "
      "{} lost, {} restarts\n",
      counts.ticks, fixed(elapsed.count(), 1), rows, counts.unpublished, counts.fetched,
      counts.lost, counts.restarts);
}

}  // namespace

void add_pose(Command odom) {
  auto options = std::make_shared<PoseOptions>();
  Command command = odom.add_subcommand("pose", "Read the pose that the daemon publishes");
  add_segment_option(command, options->shm);
  command.add_choice("--clock", options->clock, clocks(),
                     "Clock of the times shown; default: monotonic");
  add_wait_option(command, options->wait_s);
  command.add_flag("--follow", options->follow,
                   "Print poses continuously: five lines per second; with --csv, every tick");
  command.add_flag("--json", options->json, "Print the pose as JSON, in SI units",
                   {excludes("--follow")});
  command.add_flag("--csv", options->csv,
                   "Print rows in the format of odom replay, without the calibrations",
                   {needs("--follow")});
  command.add_flag("--until-stale", options->until_stale, "End when the daemon ends",
                   {needs("--follow")});
  command.footer(
      "Examples:\n"
      "  odom pose\n"
      "  odom pose --follow\n"
      "  odom pose --follow --csv --clock log --until-stale --wait 10 >live.csv\n"
      "--follow continues across restarts of the daemon. INT and TERM end it; it then prints a\n"
      "summary on standard error.");
  command.callback([options] {
    odom::Client client = attach(options->shm, options->wait_s);
    if (options->follow)
      follow(*options, std::move(client));
    else
      print_once(*options, client);
  });
}

}  // namespace odomd::tools
