// odom fault as a program.
#include <sys/socket.h>
#include <nlohmann/json.hpp>
#include <odom/odom.hpp>

#include <optional>
#include <sstream>

#include "base/wall_clock.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/fault/live.hpp"

namespace odomd::fault::fault_program_test {
namespace {

using tools::contents;
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
  static std::string in(const std::string& name) { return scratch().path(name).string(); }
  static Outcome fault(const std::string& options) {
    return run_shell("odom fault --config " + in("drive/car.toml") + " " + options);
  }
};

// One message's lines differ during the fault; no other character of the log changes.
TEST_F(FaultCommand, ChangesTheFramesThatAreMeant) {
  const std::string out = in("gyro.log");
  const Outcome outcome =
      fault("--kind gyro.zero --begin 4 --for 2 " + in("drive/drive.log") + " -o " + out);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_THAT(outcome.err, HasSubstr("gyro.zero: 400 frames\n"));
  const auto before = lines_of(contents(in("drive/drive.log")));
  const auto after = lines_of(contents(out));
  ASSERT_EQ(after.size(), before.size());
  const double start = std::stod(before.front().substr(1));
  int changed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (after[i] == before[i]) continue;
    ++changed;
    EXPECT_THAT(after[i], HasSubstr(" can0 1A2#"));
    const double t = std::stod(after[i].substr(1)) - start;
    EXPECT_GE(t, 4.0);
    EXPECT_LT(t, 6.0);
  }
  EXPECT_GT(changed, 390);
  EXPECT_LE(changed, 400);
}

TEST_F(FaultCommand, SeveralFaultsInBothLogs) {
  const Outcome outcome = fault("--fault wheels.scaled:3::1.1 --fault camera.lost:5:2 " +
                                in("drive/drive.log") + " --out " + in("both.log") + " --camera " +
                                in("drive/camera.csv") + " --camera-out " + in("both.csv"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto before = lines_of(contents(in("drive/camera.csv")));
  const auto after = lines_of(contents(in("both.csv")));
  EXPECT_EQ(before.front(), after.front());
  EXPECT_NEAR(static_cast<double>(before.size() - after.size()), 2.0 / 0.035, 5.0);
}

// As a filter it gives the same bytes as from file to file, and passes each line on at once.
TEST_F(FaultCommand, IsAFilter) {
  ASSERT_EQ(
      fault("--kind imu.noisy --seed 3 " + in("drive/drive.log") + " -o " + in("file.log")).status,
      0);
  const Outcome piped =
      fault("--kind imu.noisy --seed 3 - -o - < " + in("drive/drive.log") + " > " + in("pipe.log"));
  EXPECT_EQ(piped.status, 0) << piped.err;
  EXPECT_EQ(contents(in("pipe.log")), contents(in("file.log")));

  // The pipe stays open until all five lines have come out, or the loop's limit is reached.
  const Outcome live = run_shell(
      "cd " + in("drive") +
      "; mkfifo in; { odom fault --config car.toml --kind gyro.zero - -o - < in > out.log "
      "2> /dev/null & }; exec 3> in; head -n 5 drive.log >&3; for i in $(seq 400); do "
      "[ $(wc -l < out.log) = 5 ] && break; sleep 0.05; done; wc -l < out.log; exec 3>&-; wait");
  EXPECT_EQ(live.out, "5\n");
}

// A log that breaks off in the middle leaves no output.
TEST_F(FaultCommand, AnOutputIsWholeOrNotThere) {
  std::ofstream{in("broken.log")} << "(1.000000) can0 1A2#0000000000000000\nnonsense\n(2) x\n";
  EXPECT_THAT(fault("--strict --kind gyro.zero " + in("broken.log") + " -o " + in("not.log")),
              Ends(2, HasSubstr("broken.log:3")));
  EXPECT_FALSE(std::filesystem::exists(in("not.log")));
  EXPECT_FALSE(std::filesystem::exists(in("not.log.partial")));
  // Nor does an unusable camera log.
  std::ofstream{in("broken.csv")} << "t,x\n1,2\n";
  EXPECT_EQ(fault("--kind gyro.zero " + in("drive/drive.log") + " -o " + in("not.log") +
                  " --camera " + in("broken.csv") + " --camera-out " + in("not.csv"))
                .status,
            2);
  EXPECT_FALSE(std::filesystem::exists(in("not.log")));
}

TEST_F(FaultCommand, ErrorsSayHowToFixThem) {
  const std::string log = in("drive/drive.log") + " -o " + in("x.log");
  const std::string before = contents(in("drive/drive.log"));
  tools::expect_refused(
      "odom fault --config " + in("drive/car.toml") + ' ',
      {{"--kind gyro.forzen " + log,
        HasSubstr("there is no kind of fault \"gyro.forzen\"; the nearest is 'gyro.frozen'; odom "
                  "fault --list shows all\n")},
       {"--kind weels.zero " + log, HasSubstr("'wheels.zero'")},
       {"--kind motor.zero " + log, HasSubstr("[can.signals] maps no motor")},
       {log, HasSubstr("--kind (or --fault) is required")},
       {"--kind gyro.zero " + in("drive/drive.log"), HasSubstr("--out (for LOG) is required")},
       {"--kind camera.lost " + log, HasSubstr("--camera and --camera-out")},
       {"--kind gyro.zero --camera " + in("drive/camera.csv") + " --camera-out " + in("x.csv"),
        HasSubstr("LOG and --out")},
       {"--kind gyro.zero --from vcan7 --to vcan8 " + log, HasSubstr("not both")},
       {"--kind gyro.zero --from vcan7 --to vcan7", HasSubstr("is the interface of --from")},
       {"--kind bus.shifted --from vcan7 --to vcan8", HasSubstr("bus.delayed")},
       {"--kind gyro.zero --begin 4 --for 0 " + log, HasSubstr("--for")},
       {"--kind gyro.zero " + in("drive/drive.log") + " -o " + in("drive/drive.log"),
        HasSubstr("is what is read; name another file")}});
  EXPECT_THAT(fault("--kind gyro.zero --from vcan7 --to vcan8").err, HasSubstr("vcan"));
  EXPECT_EQ(contents(in("drive/drive.log")), before);
}

TEST_F(FaultCommand, AFaultThatNeverComesIsWarnedOf) {
  EXPECT_THAT(
      fault("--kind gyro.zero --begin 900 " + in("drive/drive.log") + " -o " + in("never.log")),
      Ends(0,
           HasSubstr("warning: gyro.zero: had no effect; it begins 900 s after the first frame")));
}

TEST_F(FaultCommand, ListsTheKinds) {
  EXPECT_THAT(must_run("odom fault --list"), HasSubstr("repeats its last value"));
  const Outcome json = run_shell("odom fault --list --json");
  EXPECT_GT(nlohmann::json::parse(json.out).size(), 67U);
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
      : socket_({.path = path, .type = daemon::SocketType::packets}) {}

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
  /// Sends a message from a new camera, which stays.
  void send(const odom_camera_message& message) {
    ASSERT_EQ(camera_.emplace().open(scratch_.path("fault.sock").c_str()), 0);
    ASSERT_EQ(camera_->send(message), 0);
  }

  tools::Scratch scratch_;
  std::optional<odom::CameraSender> camera_;
};

TEST_F(Relay, HandsPosesOnWithTheirFault) {
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

TEST_F(Relay, NobodyBehindItIsAnError) {
  EXPECT_THAT(tools::message_of([&] { (void)relay({}); }), HasSubstr("is odomd running"));
}

}  // namespace
}  // namespace odomd::fault::fault_program_test
