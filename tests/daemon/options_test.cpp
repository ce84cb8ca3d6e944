// The effect of the command line on a configuration, with the options of a service.
#include "daemon/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace odomd::daemon::options_test {
namespace {

class OptionsTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "odomd_options_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  /// The configuration of a car whose file ends with `text`.
  [[nodiscard]] Config configured(const std::string& text, Options options = {}) const {
    options.config = directory_ / "car.toml";
    std::ofstream(options.config) << "[can]\ndbc = \"car.dbc\"\n"
                                     "signals.wheel_rear = { message = \"M\", signal = \"S\", "
                                     "unit = \"m/s\" }\n"
                                  << text;
    return configure(options);
  }

  std::filesystem::path directory_;
};

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

TEST_F(OptionsTest, TheRuntimeDirectoryHoldsWhateverTheFileSays) {
  Options options;
  options.runtime_directory = "/run/odomd/can0";
  const Config config = configured(elsewhere, options);
  EXPECT_EQ(config.shm.name, "/run/odomd/can0/pose");
  EXPECT_EQ(config.status.socket, "/run/odomd/can0/status.sock");
  EXPECT_EQ(config.camera.socket, "/run/odomd/can0/camera.sock");
  EXPECT_TRUE(config.camera.configured);
}

TEST_F(OptionsTest, TheRuntimeDirectoryBringsNoCamera) {
  Options options;
  options.runtime_directory = "/run/odomd/can0";
  EXPECT_FALSE(configured("", options).camera.configured);
}

TEST_F(OptionsTest, APathOfItsOwnBeatsTheRuntimeDirectory) {
  Options options;
  options.runtime_directory = "/run/odomd/can0";
  options.shm = "/desk";
  options.status_socket = "/tmp/status.sock";
  options.camera_socket = "/tmp/camera.sock";
  const Config config = configured("", options);
  EXPECT_EQ(config.shm.name, "/desk");
  EXPECT_EQ(config.status.socket, "/tmp/status.sock");
  EXPECT_EQ(config.camera.socket, "/tmp/camera.sock");
}

TEST_F(OptionsTest, SocketsWithoutAPathAreInTheRuntimeDirectoryOfAnOrdinaryUser) {
  const bool ordinary = ::access("/run", W_OK) != 0 && ::access("/run/odomd", W_OK) != 0;
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", directory_.c_str(), 1), 0);
  const Config config = configured("[camera]\nlever_arm = [0.1, 0.0, 0.0]\n");
  const std::filesystem::path directory = ordinary ? directory_ / "odomd" : "/run/odomd";
  EXPECT_EQ(config.camera.socket, directory / "camera.sock");
  EXPECT_EQ(config.status.socket, directory / "status.sock");
  EXPECT_EQ(record_socket(config), directory / "record.sock");
  EXPECT_EQ(config.shm.name, "/odomd");
}

TEST_F(OptionsTest, ReadersAloneReachThePoseAndTheStatus) {
  Options options;
  options.readers = "odom";
  const Config config = configured(elsewhere, options);
  EXPECT_EQ(config.shm.mode, 0640U);
  EXPECT_EQ(config.shm.group, "odom");
  EXPECT_EQ(config.status.socket_mode, 0660U);
  EXPECT_EQ(config.status.socket_group, "odom");
  EXPECT_EQ(config.camera.socket_group, "video");
}

TEST_F(OptionsTest, CameraSendersAloneReachTheCamera) {
  Options options;
  options.camera_senders = "odomd-camera";
  const Config config = configured(elsewhere, options);
  EXPECT_EQ(config.camera.socket_mode, 0660U);
  EXPECT_EQ(config.camera.socket_group, "odomd-camera");
  EXPECT_EQ(config.shm.mode, 0644U);
  EXPECT_EQ(config.status.socket_mode, 0666U);
}

TEST_F(OptionsTest, WithoutThemTheFileCounts) {
  const Config config = configured(elsewhere);
  EXPECT_EQ(config.shm.name, "/elsewhere");
  EXPECT_EQ(config.shm.group, "video");
  EXPECT_EQ(config.status.socket, "/elsewhere/status.sock");
  EXPECT_EQ(config.status.socket_group, "video");
  EXPECT_EQ(config.camera.socket, "/elsewhere/camera.sock");
}

}  // namespace
}  // namespace odomd::daemon::options_test
