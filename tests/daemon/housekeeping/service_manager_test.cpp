// Notifications to a service manager, over a socket like that of systemd.
#include "daemon/housekeeping/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace odomd::daemon::service_manager_test {
namespace {

class ServiceManagerTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "odomd_notify_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
    const auto path = directory_ / "notify";
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.native().copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(socket_);
    std::filesystem::remove_all(directory_);
  }

  [[nodiscard]] std::string heard() const {
    char text[256];
    const ssize_t size = ::recv(socket_, text, sizeof text, 0);
    return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "";
  }

  std::filesystem::path directory_;
  int socket_ = -1;
};

TEST_F(ServiceManagerTest, HearsTheStateOfTheDaemon) {
  notify_ready();
  EXPECT_EQ(heard(), "READY=1");
  notify_status("tracking");
  EXPECT_EQ(heard(), "STATUS=tracking");
  notify_stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST_F(ServiceManagerTest, IsFedWhileTheTicksMove) {
  ::setenv("WATCHDOG_USEC", "300000", 1);  // to be notified every 0.1 s
  Watchdog watchdog;
  watchdog.notify(20, 1'000'000'000);
  EXPECT_EQ(heard(), "WATCHDOG=1");
  watchdog.notify(30, 1'050'000'000);
  EXPECT_EQ(heard(), "") << "not yet due";
  watchdog.notify(40, 1'100'000'000);
  EXPECT_EQ(heard(), "WATCHDOG=1");
  watchdog.notify(40, 1'200'000'000);
  watchdog.notify(40, 9'000'000'000);
  EXPECT_EQ(heard(), "") << "a beat that hangs starves it";
  watchdog.notify(41, 9'000'000'001);
  EXPECT_EQ(heard(), "WATCHDOG=1");
}

TEST_F(ServiceManagerTest, IsLeftAloneWhereItWantsNoWatchdog) {
  Watchdog watchdog;
  watchdog.notify(1, 1'000'000'000);
  EXPECT_EQ(heard(), "");
}

}  // namespace
}  // namespace odomd::daemon::service_manager_test
