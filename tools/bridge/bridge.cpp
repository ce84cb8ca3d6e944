#include "tools/bridge/bridge.hpp"
#include "tools/bridge/pose_intake.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/tick_follower.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

class Bridge {
 public:
  Bridge(const BridgeOptions& options, const std::vector<std::unique_ptr<Sink>>& sinks,
         PoseIntake* intake)
      : options_(options), sinks_(sinks), intake_(intake) {}

  void run() {
    while (sinks_.empty() && !interrupt_.requested() && !duration_is_over()) {
      poll_intake(std::chrono::milliseconds{50});
      show_status();
    }
    if (auto client = sinks_.empty() ? std::nullopt : wait_for_daemon()) follow(std::move(*client));
    print_summary();
  }

 private:
  [[nodiscard]] double elapsed() const {
    return std::chrono::duration<double>(steady_clock::now() - start_).count();
  }
  [[nodiscard]] bool duration_is_over() const {
    return options_.duration_s > 0.0 && elapsed() >= options_.duration_s;
  }

  void poll_intake(std::chrono::milliseconds wait) {
    if (intake_ == nullptr) return std::this_thread::sleep_for(wait);
    intake_->poll(wait);
    for (const std::string& message : intake_->take_messages()) {
      progress_.end();
      say("odom bridge: " + message);
    }
  }

  // Returns nothing if the bridge was stopped before a daemon came.
  std::optional<odom::Client> wait_for_daemon() {
    const char* const name = options_.shm.empty() ? nullptr : options_.shm.c_str();
    for (bool reported = false; !interrupt_.requested(); reported = true) {
      auto opened = odom::Client::open(name);
      if (opened.has_value()) return std::move(opened.value);
      // For any other error, or after the time limit, attach() throws the usual message.
      if (opened.status != ODOM_NO_SEGMENT || duration_is_over()) return attach(options_.shm, 0.0);
      if (!reported)
        say("odom bridge: waiting for the daemon: " + segment_asked_for(options_.shm) + ": " +
            opened.message());
      poll_intake(std::chrono::milliseconds{50});
    }
    return std::nullopt;
  }

  void follow(odom::Client client) {
    constexpr std::chrono::milliseconds timeout{100};
    TickFollower follower{std::move(client)};
    while (!interrupt_.requested() && !duration_is_over()) {
      const auto status =
          follower.follow(timeout, [&](const odom_pose& pose) { take(follower.client(), pose); });
      counts_ = follower.counts();
      poll_intake({});
      if (status == ODOM_OK) show_status();
      if (!follower.falls_silent(status)) continue;
      progress_.end();
      say("odom bridge: the daemon has stopped publishing; waiting for it");
    }
  }

  // Sends the first tick received of every n, so that missed ticks do not matter.
  void take(odom::Client& client, const odom_pose& pose) {
    newest_ = pose;
    if (pose.mode == ODOM_INITIALISING) {
      ++initialising_;
      return;
    }
    const auto info = client.info();
    if (!info.has_value()) return;
    const double ticks = 1e9 / (options_.rate_hz * static_cast<double>(info->period_ns));
    const auto n =
        static_cast<std::uint64_t>(std::clamp(std::llround(ticks), 1LL, 1'000'000'000LL));
    const std::uint64_t turn = pose.tick / n;
    if (turn == last_turn_ && info->instance_id == instance_) return;
    last_turn_ = turn;
    instance_ = info->instance_id;

    const auto newest = client.latest_details();
    if (newest.has_value()) sample_.details = newest->details;
    const auto realtime = client.to_clock(ODOM_CLOCK_REALTIME, pose.time_ns);
    if (!realtime.has_value()) return;
    sample_.pose = pose;
    sample_.realtime_ns = *realtime;
    for (const auto& sink : sinks_) sink->send(sample_);
  }

  /// Shows pose and counts once a second.
  void show_status() {
    const auto now = steady_clock::now();
    if (options_.json || now < next_show_) return;
    next_show_ = now + std::chrono::seconds{1};
    std::string text = sinks_.empty() ? "" : mode_name(newest_.mode);
    if (!sinks_.empty() && newest_.mode != ODOM_INITIALISING)
      text += fmt::format(
          "  x {} m  y {} m  yaw {} deg  {} m/s", fixed(newest_.x, 2), fixed(newest_.y, 2),
          fixed(std::remainder(newest_.yaw, 2.0 * std::numbers::pi) * 180.0 / std::numbers::pi, 1),
          fixed(newest_.vx, 2));
    for (const auto& sink : sinks_) {
      const Sink::Counts& counts = sink->counts();
      text += fmt::format("  {}: {} sent", sink->name(), counts.sent);
      if (counts.dropped > 0) text += fmt::format(", {} dropped", counts.dropped);
      if (counts.withheld > 0) text += fmt::format(", {} withheld", counts.withheld);
    }
    if (intake_ != nullptr) text += "  " + received();
    progress_.show(text);
  }

  [[nodiscard]] std::string received() const {
    std::string text = intake_->topic() + ':';
    for (const auto& [name, count] : intake_->counts()) text += fmt::format(" {} {},", count, name);
    text.pop_back();
    return text;
  }

  void print_summary() {
    progress_.end();
    if (options_.json) {
      nlohmann::ordered_json json{
          {"duration", elapsed()},         {"ticks", counts_.ticks},
          {"initialising", initialising_}, {"unpublished", counts_.unpublished},
          {"fetched", counts_.fetched},    {"lost", counts_.lost},
          {"restarts", counts_.restarts},  {"sinks", nlohmann::ordered_json::array()}};
      for (const auto& sink : sinks_)
        json["sinks"].push_back({{"name", sink->name()},
                                 {"sent", sink->counts().sent},
                                 {"dropped", sink->counts().dropped},
                                 {"withheld", sink->counts().withheld}});
      if (intake_ != nullptr) json["input"] = intake_->counts();
      std::cout << json_text(json) << '\n';
      return;
    }
    std::string text = fmt::format(
        "{} ticks in {:.1f} s, {} initialising; {} missed by the daemon, {} fetched from the "
        "history, {} lost, {} restarts",
        counts_.ticks, elapsed(), initialising_, counts_.unpublished, counts_.fetched, counts_.lost,
        counts_.restarts);
    for (const auto& sink : sinks_) {
      const Sink::Counts& counts = sink->counts();
      text += fmt::format("; {}: {} sent, {} dropped, {} withheld (fault)", sink->name(),
                          counts.sent, counts.dropped, counts.withheld);
    }
    if (intake_ != nullptr) text = (sinks_.empty() ? "" : text + "; ") + received();
    say("odom bridge: " + text);
  }

  const BridgeOptions& options_;
  const std::vector<std::unique_ptr<Sink>>& sinks_;
  PoseIntake* intake_;
  Interrupt interrupt_;
  steady_clock::time_point start_ = steady_clock::now();
  ProgressLine progress_{"odom bridge", WithoutTerminal::nothing};
  steady_clock::time_point next_show_ = start_;
  odom_pose newest_{};
  FollowCounts counts_;
  std::uint64_t initialising_ = 0;
  std::uint64_t last_turn_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t instance_ = 0;
  BridgeSample sample_;
};

}  // namespace

void run_bridge(const BridgeOptions& options, const std::vector<std::unique_ptr<Sink>>& sinks,
                PoseIntake* intake) {
  Bridge(options, sinks, intake).run();
}

}  // namespace odomd::tools
