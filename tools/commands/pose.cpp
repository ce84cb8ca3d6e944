// odom pose: the pose from shared memory, once or at every tick.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/cli/daemon_options.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/commands/commands.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/status_text.hpp"
#include "tools/live/tick_follower.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

struct Options {
  std::string shm;
  bool json = false;
  bool follow = false;
  bool csv = false;
  std::string out;
  odom_clock clock = ODOM_CLOCK_MONOTONIC;
  double wait_s = 0.0;
  double duration_s = 0.0;  // 0: without end
  double rate_hz = 0.0;     // 0: every tick, or a few per second for people
  bool until_stale = false;
};

const Choices<odom_clock>& clocks() {
  static const Choices<odom_clock> names{{"monotonic", ODOM_CLOCK_MONOTONIC},
                                         {"realtime", ODOM_CLOCK_REALTIME},
                                         {"log", ODOM_CLOCK_LOG}};
  return names;
}

std::string name_of(odom_clock clock) {
  for (const auto& [name, value] : clocks()) {
    if (value == clock) return name;
  }
  return "clock";
}

constexpr const char* no_log = "the daemon is not playing a log; use --clock monotonic or realtime";

void print_once(const Options& options, odom::Client& client) {
  const auto pose = client.latest();
  if (!pose.has_value()) throw std::runtime_error(pose.message());
  const auto t = client.to_clock(options.clock, pose->time_ns);
  if (!t.has_value()) throw std::runtime_error(no_log);
  const std::int64_t age_ns =
      steady_clock::now().time_since_epoch() / std::chrono::nanoseconds{1} - pose->time_ns;
  const bool fresh = pose.status == ODOM_OK;
  std::cout << (options.json ? pose_as_json(*pose, age_ns, name_of(options.clock), *t, fresh)
                             : pose_as_text(*pose, age_ns));
  if (!fresh) {
    throw std::runtime_error("the daemon has stopped publishing: this was its last pose, " +
                             fixed(static_cast<double>(age_ns) * 1e-9, 1) + " s ago");
  }
}

// Writes the requested poses in the requested form.
class PoseWriter {
 public:
  PoseWriter(const Options& options, odom::Client& client) : options_(options), client_(client) {
    if (!options.out.empty() && options.out != "-") file_.emplace(open_output(options.out));
    if (options.csv) stream() << pose_header();
    const auto info = client.info();
    constexpr double people_hz = 5.0;
    const double rate = options.rate_hz > 0.0 ? options.rate_hz : options.csv ? 0.0 : people_hz;
    if (rate > 0.0 && info.has_value()) {
      const double ticks = 1e9 / (rate * static_cast<double>(info->period_ns));
      every_ = static_cast<std::uint64_t>(std::clamp(std::llround(ticks), 1LL, 1'000'000'000LL));
    }
  }

  void take(const odom_pose& pose) {
    if (pose.mode == ODOM_INITIALISING || pose.tick % every_ != 0) return;
    const auto t = client_.to_clock(options_.clock, pose.time_ns);
    if (!t.has_value()) {
      ++untimed_;
      return;
    }
    ++rows_;
    if (options_.csv) {
      append_pose_row(buffer_, pose, *t);
    } else {
      buffer_ += pose_as_line(pose, *t);
    }
  }

  // Flush whole batches for a reader that follows.
  void flush() {
    stream() << buffer_;
    buffer_.clear();
    if (!stream().flush()) {
      throw std::runtime_error((options_.out.empty() ? "standard output" : options_.out) +
                               ": cannot be written: " + why_unwritten(stream()));
    }
  }

  void close() {
    flush();
    if (file_) close_output(*file_, options_.out);
    if (rows_ == 0 && untimed_ > 0) throw std::runtime_error(no_log);
  }

  [[nodiscard]] std::uint64_t rows() const { return rows_; }

 private:
  std::ostream& stream() { return file_ ? *file_ : std::cout; }

  const Options& options_;
  odom::Client& client_;
  std::optional<std::ofstream> file_;
  std::string buffer_;
  std::uint64_t every_ = 1;
  std::uint64_t rows_ = 0;
  std::uint64_t untimed_ = 0;  // poses before the log's clock was known
};

void follow(const Options& options, odom::Client client) {
  // A short delay of the daemon does not count as its end.
  const std::chrono::milliseconds timeout{options.until_stale ? 500 : 100};
  TickFollower follower{std::move(client)};
  PoseWriter writer{options, follower.client()};
  Interrupt interrupt;
  const auto start = steady_clock::now();
  const auto elapsed = [start] {
    return std::chrono::duration<double>(steady_clock::now() - start).count();
  };
  bool silent = false;
  while (!interrupt.requested() && (options.duration_s <= 0.0 || elapsed() < options.duration_s)) {
    const auto status =
        follower.follow(timeout, [&writer](const odom_pose& pose) { writer.take(pose); });
    writer.flush();
    if (status == ODOM_OK) {
      silent = false;
    } else if (status == ODOM_STALE) {
      if (options.until_stale) break;
      if (!silent) std::cerr << "odom pose: the daemon has stopped publishing; waiting for it\n";
      silent = true;
    } else if (status != ODOM_TIMEOUT && status != ODOM_NO_POSE && status != ODOM_BUSY) {
      throw std::runtime_error(odom_strstatus(status));
    }
  }
  writer.close();
  const FollowCounts& counts = follower.counts();
  std::cerr << "odom pose: " << counts.ticks << " ticks in " << fixed(elapsed(), 1) << " s, "
            << writer.rows() << " rows; " << counts.unpublished << " missed by the daemon, "
            << counts.fetched << " fetched from the history, " << counts.lost << " lost, "
            << counts.restarts << " restarts\n";
}

void run_pose(const Options& options) {
  odom::Client client = attach(options.shm, options.wait_s);
  if (options.follow) {
    follow(options, std::move(client));
  } else {
    print_once(options, client);
  }
}

}  // namespace

void add_pose(Command odom) {
  auto options = std::make_shared<Options>();
  Command command = odom.add_subcommand("pose", "Read the pose that the daemon publishes");
  add_segment_option(command, options->shm);
  command.add_choice("--clock", options->clock, clocks(),
                     "Clock of the times shown; default: monotonic");
  add_wait_option(command, options->wait_s);
  command.add_flag("--follow", options->follow,
                   "Print poses as they come: five lines per second, with --csv every tick");
  command.add_flag("--json", options->json, "Print the pose as JSON, in SI units",
                   {excludes("--follow")});
  command.add_flag("--csv", options->csv,
                   "Print rows in the format of odom replay, without the calibrations",
                   {needs("--follow")});
  command.add("--out", "FILE", options->out, "Write the rows to a file instead of standard output",
              {needs("--follow")});
  command.add("--duration", "S", options->duration_s, "End after this time [s]",
              {positive(), needs("--follow")});
  command.add("--rate", "HZ", options->rate_hz,
              "Rows per second [Hz]; default: 5, with --csv every tick",
              {positive(), needs("--follow")});
  command.add_flag("--until-stale", options->until_stale, "End when the daemon ends",
                   {needs("--follow")});
  command.footer(
      "Examples:\n"
      "  odom pose\n"
      "  odom pose --follow\n"
      "  odom pose --follow --csv --out live.csv --clock log --until-stale --wait 10\n"
      "--follow continues across restarts of the daemon; INT and TERM end it, with a summary on\n"
      "standard error.");
  command.callback([options] { run_pose(*options); });
}

}  // namespace odomd::tools
