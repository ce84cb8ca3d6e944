// odom-web: odom serve. A separate program, so that odom itself does not depend on an HTTP library.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tools/cli/command_line.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/doctor/doctor.hpp"
#include "tools/live/status_value.hpp"
#include "tools/live/watch/observer.hpp"
#include "tools/live/watch/page.hpp"
#include "tools/serve/options.hpp"
#include "tools/serve/server.hpp"

namespace odomd::serve {
namespace {

using nlohmann::ordered_json;
using std::chrono::steady_clock;
namespace watch = tools::watch;

constexpr std::chrono::milliseconds period{50};
constexpr int samples_per_status = 10;
constexpr std::size_t max_history = 600;  // one minute, with every second sample

// NaN and infinity are null in JSON.
std::string numbers(std::initializer_list<double> values) {
  std::string text = "[";
  for (const double value : values)
    text += (std::isfinite(value) ? fmt::format("{:.4f}", value) : "null") + ',';
  text.back() = ']';
  return text;
}

// The head of odom watch (daemon, mode and conditions) as lines of [text, style].
ordered_json head_json(const watch::State& state) {
  constexpr std::array styles{"plain", "dim", "strong", "good", "warning", "bad", "accent"};
  ordered_json lines = ordered_json::array();
  for (const tools::Line& line : watch::head(state, 200)) {
    lines.push_back(ordered_json::array());
    for (const auto& [text, style] : line)
      lines.back().push_back({text, styles.at(static_cast<std::size_t>(style))});
  }
  return lines;
}

ordered_json sources_json(const tools::StatusValue& status) {
  ordered_json rows = ordered_json::array();
  for (const tools::StatusValue& source : status["sources"].elements())
    if (source["configured"].is_true())
      rows.push_back({source["name"].json(), tools::source_state(source),
                      source["healthy"].is_true(), source["verdicts"].rate(),
                      source["age_s"].duration(), tools::nis_by_expectation(source)});
  return rows;
}

// The status has the camera's innovation, not its pose: adds the estimated pose at the same time.
ordered_json camera_json(watch::Observer& observer) {
  const tools::StatusValue camera = observer.state().reported()["sources"].named("camera");
  const double age_s = camera["age_s"].value(1.0);
  const auto innovation = camera["innovation"].elements();
  if (innovation.size() < 2 || age_s >= 0.5) return nullptr;
  const auto then =
      observer.pose_at(observer.state().now_ns - static_cast<std::int64_t>(1e9 * age_s));
  if (!then) return nullptr;
  return {then->x + innovation[0].value(), then->y + innovation[1].value()};
}

class Sampler {
 public:
  explicit Sampler(watch::Target target) : observer_(std::move(target)) {}

  void sample_to(Server& server) {
    const bool with_status = count_++ % samples_per_status == 0;
    observer_.look(with_status ? watch::Depth::segment_and_status : watch::Depth::segment);
    const std::string pose = fmt::format("id: {}\ndata: {}\n\n", count_, pose_json());
    if (!with_status) return server.publish(pose, false);
    server.set_answers(fmt::format("[{}]", fmt::join(history_, ",")), metrics());
    server.publish(fmt::format("event: state\ndata: {}\n\n", state_json()) + pose, true);
  }

 private:
  std::string pose_json() {
    const watch::State& state = observer_.state();
    const double t = 1e-9 * static_cast<double>(state.now_ns);
    if (!state.segment || state.segment->pose.mode == ODOM_INITIALISING)
      return fmt::format(R"({{"n":{},"t":{:.3f}}})", count_, t);
    const auto& [pose, details, info, beat, silent] = *state.segment;
    const bool leapt = pose.reset_count != std::exchange(resets_, pose.reset_count) &&
                       std::hypot(pose.jump_x, pose.jump_y) > watch::Trail::leap_m;
    if (info.instance_id != std::exchange(instance_, info.instance_id) || leapt) ++stretch_;
    const std::string row =
        numbers({t, stretch_, pose.x, pose.y, pose.yaw, pose.vx, pose.vy, pose.yaw_rate});
    if (count_ % 2 == 0 && !silent) history_.push_back(row);
    if (history_.size() > max_history) history_.pop_front();
    const auto& P = pose.covariance;
    const watch::Ellipse ellipse = watch::ellipse_of({P[0], P[1], P[3]}, 3.0);
    return fmt::format(
        R"({{"n":{},"t":{:.3f},"live":{},"row":{},"ellipse":{}}})", count_, t, !silent, row,
        numbers({ellipse.long_half_axis, ellipse.short_half_axis, ellipse.direction}));
  }

  std::string state_json() {
    const watch::State& state = observer_.state();
    ordered_json json{{"head", head_json(state)}, {"problem", state.status_problem}};
    if (state.segment) {
      const odom_beat& beat = state.segment->beat;
      json["beat"] = {{"late", beat.wakeup}, {"works", beat.execution}};
      json["beat"]["text"] =
          fmt::format("{}, {} missed, {} overruns", beat.ticks, beat.missed, beat.overruns);
    }
    try {
      if (state.status) {
        json["sources"] = sources_json(state.reported());
        json["camera"] = camera_json(observer_);
        for (const auto& finding : tools::doctor::examine_daemon(*state.status, machine_))
          json["findings"].push_back({finding.subject + ": " + finding.seen, fix_of(finding)});
      }
    } catch (const tools::Json::exception&) {
      json["problem"] = "the status cannot be parsed; are odom-web and odomd of the same version?";
    }
    return tools::json_text(json);
  }

  [[nodiscard]] std::string metrics() const {
    try {
      return tools::open_metrics(observer_.state().status);
    } catch (const tools::Json::exception&) {  // a daemon of another version
      return tools::open_metrics(std::nullopt);
    }
  }

  watch::Observer observer_;
  tools::doctor::Machine machine_ = tools::doctor::read_machine();
  std::uint64_t count_ = 0;
  std::uint64_t instance_ = 0;
  std::uint32_t resets_ = 0;
  double stretch_ = 0;               // number of the trail's section; each jump starts another
  std::deque<std::string> history_;  // JSON
};

void run(const Options& options) {
  const Endpoint endpoint = endpoint_of(options);
  tools::Interrupt interrupt;  // before any other thread: the signals must reach this one
  Sampler sampler{{options.shm, options.socket}};
  Server server{endpoint};
  const bool is_v6 = endpoint.address.find(':') != std::string::npos;
  tools::say(fmt::format("odom serve: http://{}:{}/{}",
                         is_v6 ? '[' + endpoint.address + ']' : endpoint.address, server.port(),
                         endpoint.token.empty() ? "" : "?token=TOKEN"));
  for (auto next = steady_clock::now(); !interrupt.requested();
       std::this_thread::sleep_until(next)) {
    if (!server.is_listening()) throw std::runtime_error("the listening socket has failed");
    sampler.sample_to(server);
    next = std::max(next + period, steady_clock::now());
  }
}

}  // namespace
}  // namespace odomd::serve

int main(int argc, char** argv) {
  odomd::serve::Options options;
  const auto describe = [&options](odomd::tools::Command command) {
    command.program("odom serve", "odom-web " ODOMD_VERSION);
    odomd::serve::describe_serve(command, options);
    command.callback([&options] { odomd::serve::run(options); });
  };
  return odomd::tools::run_program(describe, argc, argv);
}
