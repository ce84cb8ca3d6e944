#include "daemon_process.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include "tests/unix_socket.hpp"

namespace odomd::testing {
namespace {

constexpr auto database = R"(VERSION ""
BU_: CAR
BO_ 256 WHEEL: 4 CAR
 SG_ Speed : 0|16@1- (0.001,0) [0|0] "m/s" CAR
BO_ 257 GYRO: 4 CAR
 SG_ YawRate : 0|16@1- (0.001,0) [0|0] "rad/s" CAR
BO_ 258 STEER: 2 CAR
 SG_ Angle : 0|16@1- (0.0001,0) [0|0] "rad" CAR
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_ "GenMsgCycleTime" BO_ 256 10;
BA_ "GenMsgCycleTime" BO_ 257 10;
)";

constexpr auto configuration = R"(
[vehicle]
mass = 2.985
front_axle = 0.175
rear_axle = 0.085
yaw_inertia = 0.0283384
cornering_stiffness_front = 20.0
cornering_stiffness_rear = 60.0
track_width = 0.16
[can]
source = "-"
dbc = "car.dbc"
[can.signals]
wheel_rear = { message = "WHEEL", signal = "Speed", unit = "m/s" }
yaw_rate = { message = "GYRO", signal = "YawRate", unit = "rad/s" }
steering = { message = "STEER", signal = "Angle", unit = "rad" }
[initial]
pose = [1.0, 2.0, 0.0]
[camera]
socket = "camera.sock"
[status]
socket = "status.sock"
)";

}  // namespace

Desk::Desk() {
  write("car.dbc", database);
  write("car.toml", std::string(configuration) + "[shm]\nname = \"" + segment_ + "\"\n");
}

::testing::AssertionResult Desk::logs(const std::string& text) const {
  if (eventually([&] { return read("stderr").find(text) != std::string::npos; }))
    return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << read("stderr");
}

nlohmann::json Desk::status() const {
  std::string text;
  if (const FileDescriptor connection = connected_socket(file("status.sock"), SOCK_STREAM)) {
    char buffer[4096];
    for (ssize_t size = 0; (size = ::read(connection.get(), buffer, sizeof buffer)) > 0;)
      text.append(buffer, static_cast<std::size_t>(size));
  }
  return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
}

nlohmann::json Desk::await_status(const std::function<bool(nlohmann::json&)>& fits) const {
  nlohmann::json now;
  EXPECT_TRUE(eventually([&] {
    now = status();
    return !now.is_null() && fits(now);
  })) << now.dump(1)
      << read("stderr");
  return now;
}

int Desk::odom(const std::string& arguments, const std::string& log) const {
  const std::string command = fmt::format("cd {} && " ODOMD_BIN_DIR "/odom {} >{} 2>&1",
                                          directory_.string(), arguments, log);
  const int raw = std::system(command.c_str());
  return WIFEXITED(raw) ? WEXITSTATUS(raw) : -1;
}

Client open_client(const Desk& desk) {
  odom_client* client = nullptr;
  EXPECT_TRUE(eventually([&] { return odom_open(desk.segment().c_str(), &client) == ODOM_OK; }))
      << desk.read("stderr");
  return Client(client);
}

Camera open_camera(const Desk& desk) {
  odom_camera* camera = nullptr;
  EXPECT_TRUE(eventually([&] {
    return odom_camera_open(desk.file("camera.sock").c_str(), &camera) == 0;
  })) << desk.read("stderr");
  return Camera(camera);
}

bool next_pose(const Client& client, odom_pose& pose) {
  return odom_wait(client.get(), &pose, sizeof pose, -1) == ODOM_OK;
}

bool next_pose(const Client& client, odom_pose& pose,
               const std::function<bool(const odom_pose&)>& fits) {
  return eventually([&] { return next_pose(client, pose) && fits(pose); });
}

odom_pose await_pose(const Client& client, const std::function<bool(const odom_pose&)>& fits) {
  odom_pose pose{};
  EXPECT_TRUE(next_pose(client, pose, fits));
  return pose;
}

bool becomes_stale(const Client& client, odom_pose& pose) {
  return eventually([&] { return odom_latest(client.get(), &pose, sizeof pose) == ODOM_STALE; });
}

std::string straight_drive(double seconds, double speed) {
  std::string log;
  const auto raw = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(speed * 1e3)));
  const auto steps = std::lround(seconds * 100.0);
  for (long i = 0; i < steps; ++i) {
    const long s = 1'700'000'000 + i / 100;
    const long us = i % 100 * 10'000;
    log += fmt::format("({}.{:06}) can0 100#{:02X}{:02X}0000\n", s, us, raw & 0xFFU, raw >> 8U);
    log += fmt::format("({}.{:06}) can0 101#00000000\n", s, us + 100);
    log += fmt::format("({}.{:06}) can0 102#0000\n", s, us + 200);
  }
  return log;
}

}  // namespace odomd::testing
