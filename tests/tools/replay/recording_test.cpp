// A drive through the pipeline, recorded by the beat's tap into a folder and replayed from it:
// every tick is bit-identical. Needs no daemon and no clock: the test makes the ticks.
#include <cstring>
#include <limits>
#include <memory>

#include "daemon/core/pipeline.hpp"
#include "daemon/core/recording_wire.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/recording.hpp"

namespace odomd::tools::recording_test {
namespace {

using daemon::RecordingTap;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t period = 5 * ms;
constexpr std::int64_t grid = 1'000'000 * ms;
constexpr std::int64_t realtime_offset = 1'700'000'000'001'234'567;

/// A car with a protected wheel message on one bus and the gyro on another, with all kinds of
/// events as the beat sees them.
class Car {
 public:
  explicit Car(const Scratch& scratch, const std::string& model = "paper") {
    scratch.write("wheels \"of\" car.dbc",
                  "BO_ 256 WHEEL: 4 X\n SG_ V : 0|16@1- (0.001,0) [0|0] \"m/s\" X\n"
                  " SG_ C : 16|4@1+ (1,0) [0|0] \"\" X\n"
                  "BO_ 258 STEER: 2 X\n SG_ A : 0|16@1- (0.0001,0) [0|0] \"rad\" X\n");
    scratch.write(".gyro.dbc",
                  "BO_ 2147483905 GYRO: 2 X\n SG_ R : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n");
    const auto file = scratch.write(
        "any.toml",
        "# a comment that stays\n[filter]\nmodel = \"" + model +
            "\"\n[camera]\nsocket = \"camera.sock\"\nlever_arm = [0.1, 0.02, 0.3]\n[can]\n"
            "dbc = ['wheels \"of\" car.dbc', # here, too\n  \".gyro.dbc\"]\n"
            "[can.e2e]\nWHEEL = { profile = \"COUNTER\", counter = \"C\" }\n[can.signals]\n"
            "wheel_rear = { message = \"WHEEL\", signal = \"V\", unit = \"m/s\" }\n"
            "steering = { message = \"STEER\", signal = \"A\", unit = \"rad\" }\n"
            "yaw_rate = { message = \"GYRO\", signal = \"R\", unit = \"rad/s\" }\n");
    config_ = daemon::load_config(file);
    diagnostics::Diagnostics warnings;
    const auto databases = daemon::load_databases(config_, warnings);
    pipeline_ =
        std::make_unique<daemon::Pipeline>(config_, databases, std::vector<std::string>{}, true);
    tap_ = std::make_unique<RecordingTap>(*pipeline_);
  }

  void take(can::Frame frame) {
    pipeline_->take(frame, woke_ns_);
    tap_->take(frame);
  }
  void take(const estimator::CameraPose& pose) {
    pipeline_->take(pose);
    tap_->take(pose);
  }

  /// One tick: frames of a bus, sometimes a camera pose, and all kinds of mishaps.
  void tick() {
    number_ += number_ % 50 == 17 ? 3U : 1U;  // some ticks are missed
    const std::int64_t tick_ns = grid + static_cast<std::int64_t>(number_) * period;
    woke_ns_ = tick_ns + 12'345 + static_cast<std::int64_t>(number_ % 7) * 1'001;
    const double t = static_cast<double>(number_) * 5e-3;
    if (number_ % 2 == 0) {
      can::Frame wheel = frame(256, 1.5 + 0.5 * std::sin(t), 1e-3, tick_ns - 1'234'567);
      wheel.length = 4;
      wheel.data[2] = counter_;
      take(wheel);
      if (number_ % 90 != 20) counter_ = static_cast<std::uint8_t>((counter_ + 1) % 16);
      take(frame(258, 0.2 * std::sin(0.7 * t), 1e-4, number_ % 60 == 30 ? 0 : tick_ns - 987'654));
    }
    can::Frame gyro = frame(257, 0.8 * std::cos(0.7 * t), 1e-3, tick_ns - 3'000'001);
    gyro.bus = 1;
    gyro.format = can::IdFormat::extended;
    take(gyro);
    if (number_ % 31 == 0) {
      gyro.protocol = can::FrameProtocol::fd;
      gyro.fd_flags = 1;
      gyro.length = 12;
      gyro.time_ns += 1;
      take(gyro);
    }
    if (number_ % 11 == 0) take(camera(tick_ns));
    if (number_ % 40 == 1) pipeline_->take_malformed_camera_message();
    const std::uint32_t conditions = number_ % 100 < 5 ? +ODOM_COND_CLOCK_STEPPED : 0U;
    pipeline_->set_conditions(conditions);
    const auto& record = pipeline_->tick(number_, tick_ns);
    tap_->tick_done(record, {woke_ns_, realtime_offset, conditions}, *pipeline_);
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  [[nodiscard]] RecordingTap& tap() { return *tap_; }

  /// The daemon's metadata from before its ticks.
  [[nodiscard]] RecordingStart start() const {
    return {{{"build", daemon::build_identity()},
             {"model", std::string(daemon::name_of(config_.model))},
             {"period_ns", period},
             {"camera_expected", true}},
            daemon::recording_files(config_),
            {"can0", "can1"},
            daemon::checkpoint_bytes(tap_->checkpoint())};
  }

  /// Empties the rings into the folder.
  void drain_into(RecordingFolder& folder) {
    while (const auto* mark = tap_->mark()) {
      std::vector<can::Frame> frames;
      std::vector<estimator::CameraPose> cameras;
      for (std::uint32_t i = 0; i < mark->frames; ++i) frames.push_back(tap_->take_frame());
      for (std::uint32_t i = 0; i < mark->cameras; ++i) cameras.push_back(tap_->take_camera());
      folder.take(*mark, frames, cameras);
      tap_->pop_mark();
    }
  }

 private:
  static can::Frame frame(std::uint32_t id, double value, double step, std::int64_t time_ns) {
    can::Frame frame{.time_ns = time_ns, .id = id, .length = 2};
    const auto raw = static_cast<std::int16_t>(std::lround(value / step));
    std::memcpy(frame.data.data(), &raw, sizeof raw);
    return frame;
  }
  [[nodiscard]] estimator::CameraPose camera(std::int64_t tick_ns) const {
    const double t = static_cast<double>(number_) * 5e-3;
    estimator::CameraPose pose{.capture_ns = tick_ns - 41 * ms - 77,
                               .arrival_ns = woke_ns_,
                               .x = 1.5 * t + 0.01 * std::sin(9.0 * t),
                               .y = 1.0 / 3.0,
                               .yaw = 0.3 + 0.1 * t,
                               .sigma_x = 0.05,
                               .sigma_y = 0.1 / 3.0,
                               .sigma_yaw = 0.05};
    if (number_ % 5 == 1) pose.x += 40.0;  // gated
    if (number_ % 7 == 1) pose.yaw = std::numeric_limits<double>::quiet_NaN();
    if (number_ % 7 == 2) pose.sigma_x = -0.05;
    return pose;
  }

  daemon::Config config_;
  std::unique_ptr<daemon::Pipeline> pipeline_;
  std::unique_ptr<RecordingTap> tap_;
  std::uint64_t number_ = 0;
  std::int64_t woke_ns_ = 0;
  std::uint8_t counter_ = 0;
};

RecordingReplay verify(const std::filesystem::path& folder) {
  return replay(open_recording(folder), [](const daemon::TickRecord&, std::int64_t) {});
}

class RecordingTest : public ::testing::TestWithParam<std::string> {
 protected:
  /// A recording of 400 ticks, which begins after `ticks_before` unrecorded ticks.
  std::filesystem::path record(int ticks_before, const std::string& model = "paper") {
    Car car{scratch_, model};
    car.ticks(ticks_before);
    car.tap().begin();
    car.tick();
    RecordingFolder folder{scratch_.path("drive"), car.start()};
    for (int i = 0; i < 4; ++i) {
      car.ticks(100);
      car.drain_into(folder);
      folder.flush();
    }
    counts_ = folder.counts();
    folder.close("the test is over");
    return scratch_.path("drive");
  }
  Scratch scratch_;
  RecordingCounts counts_;
};

TEST_P(RecordingTest, ReplaysToTheBitsFromAnywhereInADrive) {
  for (const int before : {0, 1, 137, 500}) {
    SCOPED_TRACE(before);
    const auto folder = record(before, GetParam());
    const RecordingReplay replayed = verify(folder);
    EXPECT_EQ(replayed.difference + replayed.inexact, "");
    EXPECT_EQ(replayed.summary.ticks, 400U);
    EXPECT_GT(replayed.summary.poses, 350U);
    EXPECT_GT(counts_.cameras, 10U);
    EXPECT_GT(counts_.unusable_cameras, 3U);
    EXPECT_GT(counts_.frames, 700U);
    std::filesystem::remove_all(folder);
  }
}
INSTANTIATE_TEST_SUITE_P(Models, RecordingTest, ::testing::Values("full", "paper", "kinematic"));

TEST_F(RecordingTest, TheCommandWritesThePosesThatWereRecordedOrThoseOfAPlainReplay) {
  const auto folder = record(137);
  EXPECT_THAT(scratch_.run("odom replay --recording drive --verify --out replayed.csv"),
              Ends(0, HasSubstr("bit-identical to what was published: 400 ticks\n")));
  const std::string live = contents(folder / "pose.csv");
  EXPECT_EQ(scratch_.text("replayed.csv"), live);

  EXPECT_THAT(scratch_.text("drive/car.toml"),
              AllOf(StartsWith("# a comment that stays\n"),
                    HasSubstr("dbc = [\"wheels _of_ car.dbc\", \"_gyro.dbc\"]\n[can.e2e]")));
  scratch_.must_run(
      "cd drive && odom replay --config car.toml --can can.log --camera camera.csv --out p.csv");
  // The replay's ticks have the same times as the daemon's.
  const std::string last_time = live.substr(live.rfind('\n', live.size() - 2) + 1, 20);
  EXPECT_THAT(contents(folder / "p.csv"), HasSubstr(last_time));
}

TEST_F(RecordingTest, ATickThatDiffersIsNamed) {
  const auto folder = record(137);
  // The record, but not the pose file, counts a camera message that never came.
  std::string beat = contents(folder / "beat.csv");
  const auto row = beat.find('\n', beat.find('\n') + 1) + 1;
  auto at = row;
  for (int field = 0; field < 11; ++field) at = beat.find(',', at) + 1;
  const auto end = beat.find(',', at);
  beat.replace(at, end - at, std::to_string(std::stoi(beat.substr(at, end - at)) + 1));
  // Drops the later rows, whose counts would have to include the message.
  scratch_.write("drive/beat.csv", beat.substr(0, beat.find('\n', row) + 1));
  const std::string difference = "tick 145 (t = 1700001000.725000000)";
  EXPECT_EQ(verify(folder).difference, difference);
  EXPECT_THAT(
      scratch_.run("odom replay --verify --recording drive"),
      Ends(1, EndsWith("odom replay: differs from the published poses: " + difference + '\n')));
}

TEST_F(RecordingTest, WithoutItsStateItBeginsAtTheRecordedPoseAndSaysSo) {
  const auto folder = record(300);
  const std::string state = contents(folder / "state.bin");
  std::string damaged = state;
  damaged[2000] = static_cast<char>(damaged[2000] + 1);
  const std::pair<std::string, const char*> cases[]{
      {damaged, "state.bin: is damaged: its checksum is wrong"},
      {"odomd 0.0.1, 9.9, 1 bytes\nxyz", "is of another build (odomd 0.0.1, 9.9"},
      {state.substr(0, 50'000), "state.bin: has 50000 bytes, not "}};
  for (const auto& [bytes, says] : cases) {
    scratch_.write("drive/state.bin", bytes);
    EXPECT_THAT(verify(folder).inexact, HasSubstr(says));
  }
  std::filesystem::remove(folder / "state.bin");
  EXPECT_THAT(verify(folder).inexact, HasSubstr("state.bin: no such file"));

  EXPECT_THAT(scratch_.run("odom replay --verify --recording drive"),
              Ends(1, HasSubstr("cannot be verified without the filter's state")));
  EXPECT_THAT(scratch_.run("odom replay --recording drive --out replayed.csv"),
              Ends(0, HasSubstr("the replay begins with the recorded pose")));
  EXPECT_GT(std::filesystem::file_size(scratch_.path("replayed.csv")), 50'000U);
}

TEST_F(RecordingTest, AsADriveItBeginsAtTheRecordedPose) {
  const auto folder = record(300);
  const auto with_initial = contents(folder / "car.toml") + "[initial]\npose = [-9, 0, 0]\n";
  scratch_.write("drive/car.toml", with_initial);
  const auto recorded = open_recording(folder).config.initial_pose.value();
  EXPECT_GT(recorded.x, 0.5);
  EXPECT_EQ(read_drive({.folder = folder}).config.initial_pose.value().x, recorded.x);
  scratch_.write("drive/info.json", "{}");
  EXPECT_THROW(static_cast<void>(read_drive({.folder = folder})), std::invalid_argument);
}

TEST_F(RecordingTest, ARecordingThatLostItsEndReplaysWhatIsThere) {
  namespace fs = std::filesystem;
  const auto folder = record(137);
  // Cuts the file, if possible in the middle of a row.
  fs::resize_file(folder / "beat.csv", fs::file_size(folder / "beat.csv") * 2 / 3);
  const RecordingReplay replayed = verify(folder);
  EXPECT_EQ(replayed.difference, "");
  EXPECT_GT(replayed.summary.ticks, 250U);
  EXPECT_LT(replayed.summary.ticks, 400U);
}

TEST_F(RecordingTest, FilesThatDoNotFitEachOtherAreRefused) {
  const auto folder = record(137);
  const std::string frames = contents(folder / "can.log");
  const std::array<std::array<std::string, 3>, 7> cases{
      {{"can.log", frames.substr(0, frames.rfind('\n', frames.size() / 2) + 1),
        "can.log ends before this tick"},
       {"can.log", "", "beat.csv:3: can.log ends before this tick"},
       {"can.log", frames.substr(frames.find('\n') + 1), "frames of another bus"},
       {"camera.csv", "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n",
        "camera.csv ends before this tick"},
       {"info.json", "{\"format\": 2}", "info.json: is of format 2, this odom reads 1"},
       {"info.json", "[]", "info.json: is not in the format of odom record"},
       {"info.json", "", "info.json: is not in the format of odom record"}}};
  for (const auto& [file, text, says] : cases) {
    const std::string before = contents(folder / file);
    scratch_.write("drive/" + file, text);
    EXPECT_THAT(message_of([&] { static_cast<void>(verify(folder)); }), HasSubstr(says));
    scratch_.write("drive/" + file, before);
  }
  EXPECT_THAT(message_of([] { static_cast<void>(open_recording("/nonexistent")); }),
              HasSubstr("/nonexistent/info.json: no such file"));
}

TEST_F(RecordingTest, DoesNotWriteIntoAnExistingFolder) {
  record(0);
  Car car{scratch_};
  car.tap().begin();
  car.tick();
  EXPECT_THAT(message_of([&] { RecordingFolder(scratch_.path("drive"), car.start()); }),
              HasSubstr("drive: exists already; name another folder"));
  EXPECT_THAT(message_of([&] { RecordingFolder(scratch_.path("no/drive"), car.start()); }),
              HasSubstr("no/drive: cannot be created: No such file or directory"));
}

TEST(ReplayOfARecording, ExcludesWhatTheRecordingKnows) {
  const Scratch drive;
  drive.write("drive.log", "");
  expect_answers(drive, 2, "odom replay", R"(
--recording x --config y --out - -> excludes
--recording x --initial 0,0,0 --out - -> excludes
--recording x -> --out
--config y --out - --verify -> --recording
--out - -> --config
--out - --recording . -> is a drive, not a recording of odom record: replay it with
--recording x --out - -> x/info.json: no such
)");
}

}  // namespace
}  // namespace odomd::tools::recording_test
