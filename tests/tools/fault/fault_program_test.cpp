// odom fault as a program.
#include <sys/socket.h>
#include <odom/odom.hpp>

#include <optional>

#include "base/wall_clock.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/fault/live.hpp"

namespace odomd::fault::fault_program_test {
namespace {

using tools::Ends;
using tools::must_run;
using tools::Outcome;
using tools::run_shell;
using tools::Scratch;

// odom fault, the built program, on logs and through pipes.

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream{text};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// A short simulated drive, made once.
class FaultCommand : public ::testing::Test {
 protected:
  static const Scratch& scratch() {
    static const tools::SharedDrive made{"--laps 1 --scenario lap --standstill 1"};
    return made.scratch;
  }
  static Outcome fault(const std::string& options) {
    return scratch().run("odom fault --config drive/car.toml " + options);
  }
  static bool exists(const char* name) { return std::filesystem::exists(scratch().path(name)); }
};

// Only the lines of one message change, and only during the fault.
TEST_F(FaultCommand, ChangesOnlyTheFramesOfTheFault) {
  const Outcome outcome = fault("--kind gyro.zero --begin 4 --for 2 drive/drive.log -o gyro.log");
  EXPECT_THAT(outcome, Ends(0, HasSubstr("gyro.zero: 400 frames\n")));
  EXPECT_THAT(outcome.out, IsEmpty());
  const auto before = lines_of(scratch().text("drive/drive.log"));
  const auto after = lines_of(scratch().text("gyro.log"));
  ASSERT_EQ(after.size(), before.size());
  const double start = std::stod(before.front().substr(1));
  int changed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (after[i] == before[i]) continue;
    ++changed;
    EXPECT_THAT(after[i], HasSubstr(" can0 1A2#"));
    const double t = std::stod(after[i].substr(1)) - start;
    EXPECT_TRUE(t >= 4.0 && t < 6.0) << t;
  }
  EXPECT_GT(changed, 390);
  EXPECT_LE(changed, 400);
}

TEST_F(FaultCommand, SeveralFaultsInBothLogs) {
  const Outcome outcome = fault(
      "--fault wheels.scaled:3::1.1 --fault camera.lost:5:2 drive/drive.log "
      "--out both.log --camera drive/camera.csv --camera-out both.csv");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto before = lines_of(scratch().text("drive/camera.csv"));
  const auto after = lines_of(scratch().text("both.csv"));
  EXPECT_EQ(before.front(), after.front());
  EXPECT_NEAR(static_cast<double>(before.size() - after.size()), 2.0 / 0.035, 5.0);
}

// As a filter, odom fault writes the same bytes as to a file, and passes each line on immediately.
TEST_F(FaultCommand, IsAFilter) {
  EXPECT_EQ(fault("--kind imu.noisy --seed 3 drive/drive.log -o file.log").status, 0);
  const Outcome piped = fault("--kind imu.noisy --seed 3 - -o - < drive/drive.log");
  EXPECT_EQ(piped.status, 0) << piped.err;
  EXPECT_EQ(piped.out, scratch().text("file.log"));

  // The pipe stays open until all five lines have come out, or the loop's limit is reached.
  const Outcome live = scratch().run(
      "cd drive; mkfifo in; { odom fault --config car.toml --kind gyro.zero - -o - < in > out.log "
      "2> /dev/null & }; exec 3> in; head -n 5 drive.log >&3; for i in $(seq 400); do "
      "[ $(wc -l < out.log) = 5 ] && break; sleep 0.05; done; wc -l < out.log; exec 3>&-; wait");
  EXPECT_EQ(live.out, "5\n");
}

// Neither a log that breaks off in the middle nor an unusable camera log leaves an output.
TEST_F(FaultCommand, AnOutputIsCompleteOrAbsent) {
  scratch().write("broken.log", "(1.000000) can0 1A2#0000000000000000\nnonsense\n(2) x\n");
  scratch().write("broken.csv", "t,x\n1,2\n");
  tools::expect_answers(scratch(), 2, "odom fault --config drive/car.toml --kind gyro.zero", R"(
--strict broken.log -o not.log -> broken.log:3
drive/drive.log -o not.log --camera broken.csv --camera-out not.csv -> broken.csv:1
)");
  EXPECT_EQ(scratch().run("ls | grep -e not -e partial").out, "");
}

TEST_F(FaultCommand, ErrorsSayHowToFixThem) {
  const std::string before = scratch().text("drive/drive.log");
  tools::expect_answers(scratch(), 2, "odom fault --config drive/car.toml", R"(
--kind gyro.forzen drive/drive.log -o x -> odom fault: there is no kind of fault "gyro.forzen";
  the nearest is 'gyro.frozen'; odom fault --list shows all
--kind weels.zero drive/drive.log -o x -> 'wheels.zero'
--kind motor.zero drive/drive.log -o x -> [can.signals] maps no motor
drive/drive.log -o x -> --kind (or --fault) is required
--kind gyro.zero drive/drive.log -> --out (for LOG) is required
--kind camera.lost drive/drive.log -o x -> --camera and --camera-out
--kind gyro.zero --camera drive/camera.csv --camera-out x.csv -> LOG and --out
--kind gyro.zero --from vcan7 --to vcan8 drive/drive.log -o x -> not both
--kind gyro.zero --from vcan7 --to vcan7 -> is the interface of --from
--kind bus.shifted --from vcan7 --to vcan8 -> bus.delayed
--kind gyro.zero --begin 4 --for 0 drive/drive.log -o x -> --for
--kind gyro.zero drive/drive.log -o drive/drive.log -> is what is read; name another file
)");
  EXPECT_THAT(fault("--kind gyro.zero --from vcan7 --to vcan8").err, HasSubstr("vcan"));
  EXPECT_EQ(scratch().text("drive/drive.log"), before);
}

TEST_F(FaultCommand, WarnsOfAFaultThatNeverBegins) {
  EXPECT_THAT(
      fault("--kind gyro.zero --begin 900 drive/drive.log -o never.log"),
      Ends(0,
           HasSubstr("warning: gyro.zero: had no effect; it begins 900 s after the first frame")));
}

TEST_F(FaultCommand, ListsTheKinds) {
  EXPECT_THAT(must_run("odom fault --list"), HasSubstr("repeats its last value"));
  EXPECT_GT(scratch().json("odom fault --list --json").size(), 67U);
}

// Camera poses through two sockets: a camera sends, a fault changes them, a daemon receives.

odom_camera_message message_at(double x) {
  odom_camera_message message{};
  message.clock = ODOM_CLOCK_REALTIME;
  message.capture_ns = 123'456'789;
  message.x = x;
  message.sigma_x = message.sigma_y = message.sigma_yaw = 0.01;
  return message;
}

// The daemon's end of the connection.
class Daemon {
 public:
  explicit Daemon(const std::filesystem::path& path)
      : socket_({.file = daemon::socket_at(path), .type = daemon::SocketType::packets}) {}

  std::optional<odom_camera_message> receive() {
    if (!connection_) connection_ = socket_.accept();
    odom_camera_message message{};
    const ssize_t size = ::recv(connection_.get(), &message, sizeof message, MSG_DONTWAIT);
    if (size != sizeof message) return std::nullopt;
    return message;
  }

 private:
  daemon::LocalSocket socket_;
  FileDescriptor connection_;
};

class Relay : public ::testing::Test {
 protected:
  CameraRelay relay(const std::vector<const char*>& kinds) const {
    std::vector<Fault> faults;
    for (const char* kind : kinds) faults.push_back(fault_of(parse_kind(kind)));
    return {scratch_.path("fault.sock"), scratch_.path("daemon.sock").string(), 0.0, faults, 0};
  }
  /// Sends a message from a new camera, which stays connected.
  void send(const odom_camera_message& message) {
    ASSERT_EQ(camera_.emplace().open(scratch_.path("fault.sock").c_str()), 0);
    ASSERT_EQ(camera_->send(message), 0);
  }

  tools::Scratch scratch_;
  std::optional<odom::CameraSender> camera_;
};

TEST_F(Relay, ForwardsPosesWithTheirFaults) {
  Daemon daemon(scratch_.path("daemon.sock"));
  CameraRelay relay = this->relay({"camera.moved", "camera.early"});
  send(message_at(1.0));
  relay.pass_on(monotonic_now());
  const auto received = daemon.receive();
  ASSERT_TRUE(received);
  EXPECT_NEAR(received->x, 1.5, 1e-12);
  EXPECT_EQ(received->clock, ODOM_CLOCK_REALTIME);
  EXPECT_EQ(received->capture_ns, 73'456'789);
  EXPECT_EQ(relay.relayed().sent, 1U);
}

TEST_F(Relay, HoldsDelayedPosesBack) {
  Daemon daemon(scratch_.path("daemon.sock"));
  CameraRelay relay = this->relay({"camera.delayed"});
  send(message_at(1.0));
  const std::int64_t now_ns = monotonic_now();
  for (const auto& [after_ns, comes] :
       {std::pair{0, false}, {99'000'000, false}, {100'000'000, true}}) {
    relay.pass_on(now_ns + after_ns);
    EXPECT_EQ(daemon.receive().has_value(), comes) << after_ns;
  }
}

// Cameras that disconnect and reconnect, and one that sends nonsense.
TEST_F(Relay, CamerasComeAndGo) {
  Daemon daemon(scratch_.path("daemon.sock"));
  CameraRelay relay = this->relay({});
  for (int i = 0; i < 3; ++i) {
    send(message_at(1.0));
    relay.pass_on(monotonic_now());
    EXPECT_TRUE(daemon.receive());
  }
  odom_camera_message wrong = message_at(1.0);
  wrong.sigma_x = 1.0;
  send(wrong);
  relay.pass_on(monotonic_now());
  EXPECT_EQ(relay.relayed().received, 4U);
  EXPECT_EQ(relay.relayed().malformed, 0U);
}

TEST_F(Relay, AMissingDaemonIsAnError) {
  EXPECT_THAT(tools::message_of([&] { (void)relay({}); }), HasSubstr("is odomd running"));
}

}  // namespace
}  // namespace odomd::fault::fault_program_test
