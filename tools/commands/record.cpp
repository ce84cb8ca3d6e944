// odom record: the daemon's inputs and outputs, as logs that replay to the same bits.
#include <fmt/chrono.h>

#include <cstring>
#include <ctime>
#include <thread>

#include "tools/commands/commands.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/live/daemon_feeds.hpp"
#include "tools/live/daemon_link.hpp"

namespace odomd::tools {
namespace {

using daemon::RecordingMessage;
using std::chrono::steady_clock;

struct RecordOptions {
  std::string socket;
  std::string out;
  double duration_s = 0.0;  // 0: until interrupted
  double wait_s = 0.0;
  bool once = false;
};

double seconds_since(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

std::string name_of_now() {
  return fmt::format("drive-{:%Y%m%d-%H%M%S}", fmt::localtime(std::time(nullptr)));
}

// Records one drive after another until it is stopped.
class Recorder {
 public:
  explicit Recorder(const RecordOptions& options) : options_(options) {}

  void run() {
    if (!options_.out.empty() && std::filesystem::exists(options_.out)) {
      throw std::invalid_argument(options_.out +
                                  ": exists already; name another folder with --out");
    }
    while (!over()) {
      auto feed = connect();
      if (!feed) break;
      record(*feed);
      if (options_.once) break;
    }
    if (folders_ == 0) throw std::runtime_error("nothing was recorded");
  }

 private:
  [[nodiscard]] bool over() {
    return interrupt_.requested() ||
           (options_.duration_s > 0.0 && begun_ && seconds_since(*begun_) >= options_.duration_s);
  }

  // Waits for the first daemon for the given time; for the next ones without limit.
  std::optional<RecordingFeed> connect() {
    while (true) {
      try {
        socket_ = socket_path(options_.socket, "record.sock");
        return std::optional<RecordingFeed>(std::in_place, socket_);
      } catch (const NobodyThere&) {
        if (folders_ == 0 && seconds_since(start_) >= options_.wait_s) throw;
      }
      if (over()) return std::nullopt;
      std::this_thread::sleep_for(std::chrono::milliseconds{50});
    }
  }

  void record(RecordingFeed& feed) {
    constexpr auto timeout = std::chrono::milliseconds{100};
    RecordingStart start;
    std::optional<RecordingFolder> folder;
    std::string why = stopped;
    auto flushed = steady_clock::now();
    while (!over()) {
      const auto message = feed.next(timeout);
      if (message && message->kind == RecordingMessage::end) {
        why = message->bytes;
        break;
      }
      if (message) take(*message, start, folder);
      if (!message && feed.ended()) {
        why = feed.is_daemon_running() ? "odomd dropped the recorder, which did not keep up"
                                       : "odomd went away";
        break;
      }
      if (folder && seconds_since(flushed) >= flush_s) {
        folder->flush();
        flushed = steady_clock::now();
      }
      if (folder)
        progress_.show(fmt::format("{:.0f} s: {}", seconds_since(*begun_), sum_of(*folder)));
    }
    if (folder) finish(*folder, why);
  }

  void take(const RecordingFeed::Message& message, RecordingStart& start,
            std::optional<RecordingFolder>& folder) {
    switch (message.kind) {
      case RecordingMessage::refused:
        throw std::runtime_error(socket_ + ": " + std::string(message.bytes));
      case RecordingMessage::hello:
        start.hello = understood(message.bytes);
        break;
      case RecordingMessage::file:
        start.files.push_back(named_file(message.bytes));
        break;
      case RecordingMessage::buses:
        start.buses = lines(message.bytes);
        if (folder) folder->set_buses(start.buses);
        break;
      case RecordingMessage::state:
        start.state = message.bytes;
        break;
      case RecordingMessage::tick:
        if (!folder) folder.emplace(next_folder(), start);
        take_tick(message.bytes, *folder);
        break;
      case RecordingMessage::end:
        break;
    }
  }

  // Structures are sent as they are in memory: both ends must come from the same build.
  [[nodiscard]] nlohmann::ordered_json understood(std::string_view bytes) const {
    auto hello = is_nested_too_deep(bytes) ? nlohmann::ordered_json()
                                           : nlohmann::ordered_json::parse(bytes, nullptr, false);
    const std::string build = hello.is_object() ? hello.value("build", "") : "";
    if (build != daemon::build_identity()) {
      throw std::runtime_error(fmt::format(
          "{}: odomd is of another build ({}) than this odom ({}); use the odom that came with it",
          socket_, build, daemon::build_identity()));
    }
    return hello;
  }

  [[nodiscard]] daemon::RecordingFile named_file(std::string_view bytes) const {
    const auto end = bytes.find('\0');
    std::string name{bytes.substr(0, end)};
    if (end == std::string_view::npos || name.empty() || name.front() == '.' ||
        name.find('/') != std::string::npos) {
      throw std::runtime_error(socket_ + ": sends a file without a proper name");
    }
    return {name, std::string{bytes.substr(end + 1)}};
  }

  static std::vector<std::string> lines(std::string_view text) {
    std::vector<std::string> all;
    for (std::size_t end = 0; (end = text.find('\n')) != std::string_view::npos;) {
      all.emplace_back(text.substr(0, end));
      text.remove_prefix(end + 1);
    }
    return all;
  }

  void take_tick(std::string_view bytes, RecordingFolder& folder) {
    daemon::TickMark mark;
    if (bytes.size() >= sizeof mark) std::memcpy(&mark, bytes.data(), sizeof mark);
    const std::size_t frames = mark.frames * sizeof(can::Frame);
    const std::size_t cameras = mark.cameras * sizeof(estimator::CameraPose);
    if (bytes.size() != sizeof mark + frames + cameras)
      throw std::runtime_error(socket_ + ": sends a tick that is cut off");
    frames_.resize(mark.frames);
    cameras_.resize(mark.cameras);
    bytes.remove_prefix(sizeof mark);
    if (frames > 0) std::memcpy(frames_.data(), bytes.data(), frames);
    if (cameras > 0) std::memcpy(cameras_.data(), bytes.data() + frames, cameras);
    folder.take(mark, frames_, cameras_);
  }

  // The folder --out, or one named by the date; the next folders of one call get a number.
  std::filesystem::path next_folder() {
    std::string base = options_.out.empty() ? name_of_now() : options_.out;
    while (base.size() > 1 && base.back() == '/') base.pop_back();  // added by a shell's completion
    std::string name = base;
    for (int i = 2; std::filesystem::exists(name); ++i) name = fmt::format("{}-{}", base, i);
    if (folders_++ == 0) begun_ = steady_clock::now();
    say(fmt::format("recording into {}", name));
    return name;
  }

  static std::string sum_of(const RecordingFolder& folder) {
    const RecordingCounts& counts = folder.counts();
    return fmt::format("{} ticks, {} frames, {} camera poses, {:.1f} MB", counts.ticks,
                       counts.frames, counts.cameras, static_cast<double>(folder.bytes()) * 1e-6);
  }

  void finish(RecordingFolder& folder, const std::string& why) {
    folder.close(why);
    say(fmt::format("{}: {}; {}", folder.path().string(), sum_of(folder), why));
    if (why != stopped && !options_.once && !over())
      say("waiting for the next daemon, to continue in another folder; INT ends it");
  }

  void say(const std::string& text) {
    progress_.end();
    tools::say("odom record: " + text);
  }

  static constexpr double flush_s = 0.5;
  static constexpr const char* stopped = "the recorder was stopped";

  const RecordOptions& options_;
  std::string socket_;
  Interrupt interrupt_;
  steady_clock::time_point start_ = steady_clock::now();
  std::optional<steady_clock::time_point> begun_;  // start of the first folder
  ProgressLine progress_{"odom record", WithoutTerminal::nothing};
  int folders_ = 0;
  std::vector<can::Frame> frames_;
  std::vector<estimator::CameraPose> cameras_;
};

}  // namespace

void add_record(Command odom) {
  auto options = std::make_shared<RecordOptions>();
  Command command = odom.add_subcommand(
      "record", "Record a drive: everything that the running daemon receives and publishes");
  command.add("--out", "DIR", options->out, "Folder to create; default: drive-DATE-TIME");
  add_socket_option(command, options->socket, "record");
  command.add("--duration", "S", options->duration_s, "End after this time [s]", {positive()});
  add_wait_option(command, options->wait_s);
  command.add_flag("--once", options->once,
                   "End when the daemon ends, instead of waiting for its restart");
  command.footer(
      "Examples:\n"
      "  odom record\n"
      "  odom record --out lap3 --duration 120\n"
      "  odom replay --recording lap3 --verify\n"
      "  odom replay --recording lap3 --out pose.csv\n"
      "  odom replay --config lap3/car.toml --can lap3/can.log --camera lap3/camera.csv \\\n"
      "      --model kinematic --out other.csv\n"
      "A recording may begin at any time; it holds the state of the filter at its first tick.\n"
      "INT and TERM end it. When the daemon restarts, the recording continues in a new folder:\n"
      "DIR-2, DIR-3, ... Users who may read the pose ([shm] mode and group) may record.");
  command.callback([options] { Recorder(*options).run(); });
}

}  // namespace odomd::tools
