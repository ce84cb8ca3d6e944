// Before the beat starts: options, --check, and the pose to resume from.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "daemon/check.hpp"
#include "daemon/inheritance.hpp"
#include "daemon/options.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::daemon::start_test {
namespace {

using estimator::Source;

Config with_signal(std::int64_t timeout_ns, std::int64_t latency_ns) {
  Config config;
  can::SignalBinding binding;
  binding.channel = static_cast<std::uint16_t>(Source::wheel_rear);
  binding.role = "wheel_rear";
  binding.message = "WHEEL";
  binding.signals = {"REAR"};
  binding.unit = can::Unit::m_per_s;
  binding.latency_ns = latency_ns;
  config.can.bindings.push_back(binding);
  config.can.signals[binding.channel] = {true, 0.05, timeout_ns};
  return config;
}

TEST(CheckSummary, ShowsTimesSourcesAndWhoMayReachWhat) {
  const auto text = summary(with_signal(15'000'000, 7'000'000), {}, {});
  EXPECT_THAT(text,
              HasSubstr("WHEEL.REAR in m/s, sigma 0.05, time-out 0.015 s, latency 0.007 s\n"));
  EXPECT_THAT(text, HasSubstr("every 0.005 s\n"));
  Config config = with_signal(333'333'333, 0);
  const auto rounded = summary(config, {}, {});
  EXPECT_THAT(rounded, AllOf(HasSubstr("time-out 0.333333 s\n"), Not(HasSubstr("old")),
                             HasSubstr("none: give --can or [can] source")));
  config.can.sources = {"can0", "-"};
  config.shm.mode = 0640;
  config.shm.group = "odom";
  config.status.socket = "/run/odomd/status.sock";
  EXPECT_THAT(summary(config, {}, {}),
              AllOf(HasSubstr("can0 (interface)\n"), HasSubstr("standard input\n"),
                    HasSubstr("/odomd (mode 0640, group odom)\n"),
                    HasSubstr("/run/odomd/status.sock (mode 0666)\n")));
}

TEST(CheckSummary, ShowsServoGripAndLeanWhereTheyAreGiven) {
  Config config = with_signal(30'000'000, 0);
  const auto plain = summary(config, {}, {});
  for (const char* const line : {"  grip ", "  steering ", "  lean "})
    EXPECT_THAT(plain, Not(HasSubstr(line)));
  config.vehicle.grip_rear = 9.5;
  config.vehicle.steering = {.delay_s = 0.06, .lag_s = 0.1, .rate_limit = 3.0};
  config.roll_gradient = 0.12;
  const auto text = summary(config, {}, {});
  EXPECT_THAT(text, HasSubstr("front without limit, rear at most 9.5 m/s2\n"));
  EXPECT_THAT(text, HasSubstr("a command: 0.06 s delay, 0.1 s lag, rate at most 3 rad/s\n"));
  EXPECT_THAT(text, HasSubstr("roll 0.12 rad per g, pitch learnt\n"));
}

TEST(CheckSummary, EndsWithTheWarnings) {
  const diagnostics::Diagnostics warnings{
      found(diagnostics::kind("role_not_mapped"), "car.toml", "steering is not mapped")};
  EXPECT_THAT(summary(with_signal(30'000'000, 0), {}, warnings),
              EndsWith("warnings\n  " + text_of(warnings.front()) + "\n"));
}

constexpr std::int64_t now_ns = 1'000'000'000'000;

constexpr std::optional<std::int64_t> age_of(std::int64_t time_ns, odom_mode mode) {
  odom_pose pose{};
  pose.time_ns = time_ns;
  pose.mode = mode;
  return age_to_go_on_from(pose, now_ns);
}

TEST(Inheritance, GoesOnFromAYoungPose) {
  EXPECT_EQ(age_of(now_ns, ODOM_TRACKING), 0);
  EXPECT_EQ(age_of(now_ns - inheritance_ns + 1, ODOM_DEGRADED), inheritance_ns - 1);
  EXPECT_FALSE(age_of(now_ns - inheritance_ns, ODOM_TRACKING));
  EXPECT_FALSE(age_of(now_ns + 1, ODOM_TRACKING));
}

TEST(Inheritance, DoesNotGoOnFromAPoseThatIsNone) {
  EXPECT_FALSE(age_of(now_ns, ODOM_INITIALISING));
  EXPECT_FALSE(age_of(now_ns, ODOM_FAULT));
}

TEST(Inheritance, KnowsTimesFromTheEndsOfTheirRange) {
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

/// The interfaces' paths and permissions.
struct Doors {
  std::string shm, status, camera;
  std::uint32_t shm_mode = 0644, status_mode = 0666, camera_mode = 0666;
  std::string shm_group = "video", status_group = "video", camera_group = "video";
  bool operator==(const Doors&) const = default;
};
Doors doors_of(const Config& config) {
  return {config.shm.name,  config.status.socket,       config.camera.socket,
          config.shm.mode,  config.status.socket_mode,  config.camera.socket_mode,
          config.shm.group, config.status.socket_group, config.camera.socket_group};
}

TEST(Options, CountMoreThanTheFile) {
  const Doors file{"/elsewhere", "/elsewhere/status.sock", "/elsewhere/camera.sock"};
  const std::string run = "/run/odomd/can0";
  Doors in_run = file, named = file, readers = file, senders = file;
  in_run.shm = run + "/pose";
  in_run.status = run + "/status.sock";
  in_run.camera = run + "/camera.sock";
  named.shm = "/desk";
  named.status = "/tmp/status.sock";
  named.camera = "/tmp/camera.sock";
  readers.shm_mode = 0640;
  readers.status_mode = 0660;
  readers.shm_group = readers.status_group = "odom";
  senders.camera_mode = 0660;
  senders.camera_group = "odomd-camera";
  Options own{.shm = "/desk",
              .camera_socket = "/tmp/camera.sock",
              .status_socket = "/tmp/status.sock",
              .runtime_directory = run};
  const std::pair<Options, Doors> cases[]{{{}, file},
                                          {{.runtime_directory = run}, in_run},
                                          {own, named},
                                          {{.readers = "odom"}, readers},
                                          {{.camera_senders = "odomd-camera"}, senders}};
  const tools::Scratch scratch;
  for (const auto& [options, doors] : cases) {
    const Config config = configured(scratch, elsewhere, options);
    EXPECT_EQ(doors_of(config), doors) << config.shm.name;
    EXPECT_TRUE(config.camera.configured);
  }
  EXPECT_FALSE(configured(scratch, "", {.runtime_directory = run}).camera.configured);
}

TEST(Options, SocketsWithoutAPathAreInTheRuntimeDirectoryOfAnOrdinaryUser) {
  const tools::Scratch scratch;
  const bool ordinary = ::access("/run", W_OK) != 0 && ::access("/run/odomd", W_OK) != 0;
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", scratch.path("").c_str(), 1), 0);
  const Config config = configured(scratch, "[camera]\nlever_arm = [0.1, 0.0, 0.0]\n");
  const std::filesystem::path directory = ordinary ? scratch.path("") / "odomd" : "/run/odomd";
  EXPECT_EQ(config.camera.socket, directory / "camera.sock");
  EXPECT_EQ(config.status.socket, directory / "status.sock");
  EXPECT_EQ(record_socket(config), directory / "record.sock");
  EXPECT_EQ(config.shm.name, "/odomd");
}

}  // namespace
}  // namespace odomd::daemon::start_test
