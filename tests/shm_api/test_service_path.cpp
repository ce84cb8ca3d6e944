// The paths where clients look if no name is given.
#include <sys/socket.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>

#include "shm_api/libodom/service.h"
#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::shm::testing::test_service_path {
namespace {

class ServicePath : public ::testing::Test {
 protected:
  void make(const std::string& name) const {
    std::filesystem::create_directories(std::filesystem::path(directory.file(name)).parent_path());
    std::ofstream(directory.file(name)) << "here";
  }

  /// The path that is found, relative to the directory.
  [[nodiscard]] std::string found(const std::string& leaf) const {
    char* path = nullptr;
    EXPECT_EQ(odomi_service_path(directory.file("run").c_str(), leaf.c_str(), &path), ODOM_OK);
    return below(path);
  }
  [[nodiscard]] std::string found_socket(const std::string& leaf) const {
    char* path = nullptr;
    EXPECT_EQ(odomi_socket_path(directory.file("run").c_str(), leaf.c_str(), &path), ODOM_OK);
    return below(path);
  }
  /// Socket directory of a daemon that is started by hand.
  [[nodiscard]] std::string own_directory(const std::string& service) const {
    char* path = nullptr;
    EXPECT_EQ(odomi_socket_directory(service.c_str(), &path), ODOM_OK);
    return below(path);
  }
  [[nodiscard]] std::string below(char* path) const {
    const std::string result(path);
    std::free(path);
    const std::string above = directory.file("");
    return result.starts_with(above) ? result.substr(above.size()) : result;
  }

  TemporaryDirectory directory;
};

TEST_F(ServicePath, IsTheFirstInstanceOrTheDirectoryItself) {
  EXPECT_EQ(found("pose"), "run/pose");
  make("run/other");
  make("run/pose");
  EXPECT_EQ(found("pose"), "run/pose");
  for (const char* name :
       {"can2/pose", "can1/pose", "can3/pose", "can0/status.sock", ".hidden/pose"})
    make(std::string("run/") + name);
  EXPECT_EQ(found("pose"), "run/can1/pose");
  EXPECT_EQ(found("status.sock"), "run/can0/status.sock");
  const std::string longest(255, '-');  // sorts first
  make("run/" + longest + "/pose");
  EXPECT_EQ(found("pose"), "run/" + longest + "/pose");
  EXPECT_EQ(found(std::string(300, 'y')), "run/" + std::string(300, 'y'));
}

/// Sets XDG_RUNTIME_DIR while this object exists.
class RuntimeDirectory {
 public:
  explicit RuntimeDirectory(const std::string& path) {
    ::setenv("XDG_RUNTIME_DIR", path.c_str(), 1);
  }
  ~RuntimeDirectory() {
    before_ ? ::setenv("XDG_RUNTIME_DIR", before_->c_str(), 1) : ::unsetenv("XDG_RUNTIME_DIR");
  }
  RuntimeDirectory(const RuntimeDirectory&) = delete;
  RuntimeDirectory& operator=(const RuntimeDirectory&) = delete;

 private:
  static std::optional<std::string> present() {
    const char* value = std::getenv("XDG_RUNTIME_DIR");
    return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
  }
  std::optional<std::string> before_ = present();
};

TEST_F(ServicePath, PrefersTheUsersOwnDaemon) {
  const RuntimeDirectory runtime(directory.file("user"));
  make("run/can0/status.sock");
  EXPECT_EQ(found_socket("status.sock"), "run/can0/status.sock");
  make("user/odomd/here");
  {
    const auto own = listening_socket(directory.file("user/odomd/status.sock"), SOCK_STREAM);
    EXPECT_EQ(found_socket("status.sock"), "user/odomd/status.sock");
    std::filesystem::permissions(directory.file("user"), std::filesystem::perms::all);
    EXPECT_EQ(found_socket("status.sock"), "run/can0/status.sock") << "others may write there";
    std::filesystem::permissions(directory.file("user"), std::filesystem::perms::owner_all);
  }
  ASSERT_TRUE(std::filesystem::exists(directory.file("user/odomd/status.sock")));
  EXPECT_EQ(found_socket("status.sock"), "run/can0/status.sock") << "a killed daemon's is left";
  EXPECT_EQ(found_socket("record.sock"), "run/record.sock");
  EXPECT_EQ(found("status.sock"), "run/can0/status.sock") << "the service's alone";
}

TEST_F(ServicePath, ARelativeOrEmptyRuntimeDirectoryIsIgnored) {
  const RuntimeDirectory runtime("user");
  EXPECT_EQ(found_socket("status.sock"), "run/status.sock");
  EXPECT_EQ(own_directory("/nowhere/odomd"), "/nowhere/odomd");
  const RuntimeDirectory none("");
  EXPECT_EQ(own_directory("/nowhere/odomd"), "/nowhere/odomd");
}

TEST_F(ServicePath, DaemonUsesTheServiceDirectoryIfWritable) {
  const RuntimeDirectory runtime(directory.file("user"));
  make("user/here");
  EXPECT_EQ(own_directory(directory.file("run")), "run") << "it can be made";
  make("run/here");
  EXPECT_EQ(own_directory(directory.file("run")), "run");
  EXPECT_EQ(own_directory("/nowhere/odomd"), "user/odomd");
  make("plain");
  EXPECT_EQ(own_directory(directory.file("plain")), "user/odomd") << "not even root enters a file";
}

}  // namespace
}  // namespace odomd::shm::testing::test_service_path
