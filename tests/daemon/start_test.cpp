// Before the beat starts: options, --check, and the pose to resume from.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "daemon/core/record.hpp"
#include "daemon/options.hpp"
#include "daemon/run.hpp"
#include "tests/daemon/core/one_wheel.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::daemon::start_test {
namespace {

Config with_signal(std::int64_t timeout_ns, std::int64_t latency_ns) {
  Config config;
  config.can.bindings = one_wheel::bindings();
  can::SignalBinding& wheel = config.can.bindings.front();
  wheel.latency_ns = latency_ns;
  config.can.signals[wheel.channel] = {true, 0.05, timeout_ns};
  return config;
}

TEST(CheckSummary, ShowsTimesSourcesAndPermissions) {
  EXPECT_THAT(
      summary(with_signal(15'000'000, 7'000'000), {}, {}),
      AllOf(HasSubstr("WHEEL.Speed in m/s, sigma 0.05, time-out 0.015 s, latency 0.007 s\n"),
            HasSubstr("every 0.005 s\n"), Not(HasSubstr("  grip ")), Not(HasSubstr("  steering ")),
            Not(HasSubstr("  lean ")), HasSubstr("none: give --can or [can] source")));
  Config config = with_signal(333'333'333, 0);
  config.can.sources = {"can0", "-"};
  config.shm.mode = 0640;
  config.shm.group = "odom";
  config.status.path = "/run/odomd/status.sock";
  config.vehicle.grip_rear = 9.5;
  config.vehicle.steering = {.delay_s = 0.06, .lag_s = 0.1, .rate_limit = 3.0};
  config.roll_gradient = 0.12;
  const diagnostics::Diagnostics warnings{
      found(diagnostics::kind("role_not_mapped"), "car.toml", "steering is not mapped")};
  EXPECT_THAT(summary(config, {}, warnings),
              AllOf(HasSubstr("time-out 0.333333 s\n"), HasSubstr("can0 (interface)\n"),
                    HasSubstr("standard input\n"), HasSubstr("/odomd (mode 0640, group odom)\n"),
                    HasSubstr("/run/odomd/status.sock (mode 0666)\n"),
                    HasSubstr("front without limit, rear at most 9.5 m/s2\n"),
                    HasSubstr("a command: 0.06 s delay, 0.1 s lag, rate at most 3 rad/s\n"),
                    HasSubstr("roll 0.12 rad per g, pitch learnt\n"),
                    EndsWith("warnings\n  " + text_of(warnings.front()) + "\n")));
}

constexpr std::int64_t now_ns = 1'000'000'000'000;

constexpr std::optional<std::int64_t> age_of(std::int64_t time_ns, odom_mode mode) {
  odom_pose pose{};
  pose.time_ns = time_ns;
  pose.mode = mode;
  return resumable_pose_age(pose, now_ns);
}

TEST(Inheritance, ResumesOnlyFromARecentPose) {
  EXPECT_EQ(age_of(now_ns, ODOM_TRACKING), 0);
  EXPECT_EQ(age_of(now_ns - inheritance_ns + 1, ODOM_DEGRADED), inheritance_ns - 1);
  EXPECT_FALSE(age_of(now_ns - inheritance_ns, ODOM_TRACKING));
  EXPECT_FALSE(age_of(now_ns + 1, ODOM_TRACKING));
  EXPECT_FALSE(age_of(now_ns, ODOM_INITIALISING));
  EXPECT_FALSE(age_of(now_ns, ODOM_FAULT));
  // Constant expressions, in which an overflow does not compile.
  static_assert(!age_of(INT64_MIN, ODOM_TRACKING));
  static_assert(!age_of(INT64_MAX, ODOM_TRACKING));
}

/// The configuration of a car whose file ends with `text`.
Config configured(const tools::Scratch& scratch, const std::string& text, Options options = {}) {
  options.config =
      scratch.write("car.toml",
                    "[can]\ndbc = \"car.dbc\"\n"
                    "signals.wheel_rear = { message = \"M\", signal = \"S\", unit = \"m/s\" }\n" +
                        text);
  return configure(options);
}

constexpr auto elsewhere = R"([camera]
socket = "/elsewhere/camera.sock"
socket_mode = 0o666
socket_group = "video"
[shm]
name = "/elsewhere"
mode = 0o644
group = "video"
[status]
socket = "/elsewhere/status.sock"
socket_mode = 0o666
socket_group = "video"
)";

/// The interfaces' paths and permissions: shared memory, status, camera.
std::string sockets_of(const Config& config) {
  return fmt::format("{} {:o} {}, {} {:o} {}, {} {:o} {}", config.shm.name, config.shm.mode,
                     config.shm.group, config.status.path.string(), config.status.mode,
                     config.status.group, config.camera.socket.path.string(),
                     config.camera.socket.mode, config.camera.socket.group);
}

TEST(Options, OverrideTheConfiguration) {
  const std::string run = "/run/odomd/can0";
  const Options own{.shm = "/desk",
                    .camera_socket = "/tmp/camera.sock",
                    .status_socket = "/tmp/status.sock",
                    .runtime_directory = run};
  const std::pair<Options, std::string> cases[]{
      {{},
       "/elsewhere 644 video, /elsewhere/status.sock 666 video, /elsewhere/camera.sock 666 video"},
      {{.runtime_directory = run},
       run + "/pose 644 video, " + run + "/status.sock 666 video, " + run +
           "/camera.sock 666 video"},
      {own, "/desk 644 video, /tmp/status.sock 666 video, /tmp/camera.sock 666 video"},
      {{.readers = "odom"},
       "/elsewhere 640 odom, /elsewhere/status.sock 660 odom, /elsewhere/camera.sock 666 video"},
      {{.camera_senders = "odomd-camera"},
       "/elsewhere 644 video, /elsewhere/status.sock 666 video, "
       "/elsewhere/camera.sock 660 odomd-camera"}};
  const tools::Scratch scratch;
  for (const auto& [options, sockets] : cases) {
    const Config config = configured(scratch, elsewhere, options);
    EXPECT_EQ(sockets_of(config), sockets);
    EXPECT_TRUE(config.camera.configured);
  }
  EXPECT_FALSE(configured(scratch, "", {.runtime_directory = run}).camera.configured);
}

TEST(Options, PlaceSocketsInTheUsersRuntimeDirectory) {
  const tools::Scratch scratch;
  const bool ordinary = ::access("/run", W_OK) != 0 && ::access("/run/odomd", W_OK) != 0;
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", scratch.path("").c_str(), 1), 0);
  const Config config = configured(scratch, "[camera]\nlever_arm = [0.1, 0.0, 0.0]\n");
  const std::filesystem::path directory = ordinary ? scratch.path("") / "odomd" : "/run/odomd";
  EXPECT_EQ(config.camera.socket.path, directory / "camera.sock");
  EXPECT_EQ(config.status.path, directory / "status.sock");
  EXPECT_EQ(config.record.path, directory / "record.sock");
  EXPECT_EQ(config.shm.name, "/odomd");
}

}  // namespace
}  // namespace odomd::daemon::start_test
