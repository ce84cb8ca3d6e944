#include "daemon_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

namespace odomd::testing {
namespace {

constexpr auto timeout = std::chrono::seconds(10);

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

bool eventually(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

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
  const int connection = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  file("status.sock").native().copy(address.sun_path, sizeof address.sun_path - 1);
  std::string text;
  if (::connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    char buffer[4096];
    for (ssize_t size = 0; (size = ::read(connection, buffer, sizeof buffer)) > 0;)
      text.append(buffer, static_cast<std::size_t>(size));
  }
  ::close(connection);
  return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
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

Process::Process(std::vector<std::string> words, const std::vector<std::string>& more_words,
                 const std::filesystem::path& outputs) {
  words.insert(words.end(), more_words.begin(), more_words.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) std::abort();
  pid_ = ::fork();
  if (pid_ == 0) {
    const int log = ::open(outputs.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    ::dup2(ends[0], STDIN_FILENO);
    ::dup2(log, STDOUT_FILENO);
    ::dup2(log, STDERR_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  ::close(ends[0]);
  input_ = ends[1];
}

Process::~Process() {
  close_input();
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

void Process::feed(const std::string& text) const {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t written = ::write(input_, text.data() + at, text.size() - at);
    if (written <= 0) return;
    at += static_cast<std::size_t>(written);
  }
}

void Process::close_input() {
  if (input_ >= 0) ::close(input_);
  input_ = -1;
}

void Process::signal(int number) const {
  ::kill(pid_, number);
}

int Process::wait() {
  int status = 0;
  if (!eventually([&] { return ::waitpid(pid_, &status, WNOHANG) == pid_; })) return -2;
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace odomd::testing
