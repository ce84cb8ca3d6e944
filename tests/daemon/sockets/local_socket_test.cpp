#include "daemon/sockets/local_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>

#include "tests/tools/scratch.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::daemon::local_socket_test {
namespace {

FileDescriptor connect_to(const std::filesystem::path& path) {
  return connected_socket(path, SOCK_SEQPACKET);
}

class LocalSocketTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::permissions(directory_, std::filesystem::perms{0755}); }

  [[nodiscard]] LocalSocketSettings settings(std::uint32_t mode = 0660) const {
    return {{path_, mode}, SocketType::packets};
  }

  [[nodiscard]] static std::string refusal(const LocalSocketSettings& wanted) {
    return tools::message_of([&] { const LocalSocket socket(wanted); });
  }

  const tools::Scratch scratch_;
  const std::filesystem::path directory_ = scratch_.path("");
  const std::filesystem::path path_ = scratch_.path("camera.sock");
};

TEST_F(LocalSocketTest, ListensAgainAfterItsFileWasRemovedOrReplaced) {
  LocalSocket socket(settings());
  EXPECT_FALSE(socket.renew());
  std::filesystem::remove(path_);
  EXPECT_TRUE(socket.renew());
  EXPECT_FALSE(socket.renew());
  EXPECT_TRUE(connect_to(path_));
  EXPECT_TRUE(socket.accept());

  std::filesystem::remove(path_);
  scratch_.write("camera.sock", "precious");
  EXPECT_THROW(socket.renew(), std::runtime_error);
  EXPECT_EQ(tools::contents(path_), "precious");
  std::filesystem::remove(path_);
  EXPECT_TRUE(socket.renew());
}

TEST_F(LocalSocketTest, LeavesTheFileOfASuccessorAlone) {
  std::optional<LocalSocket> first(settings());
  std::filesystem::remove(path_);
  const LocalSocket second(settings());
  first.reset();
  EXPECT_TRUE(connect_to(path_));
}

TEST_F(LocalSocketTest, ListensWithItsModeAndRemovesItsFile) {
  {
    const LocalSocket socket(settings(0640));
    struct stat status {};
    ASSERT_EQ(::stat(path_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0640U);
    const FileDescriptor camera = connect_to(path_);
    EXPECT_TRUE(camera);
    EXPECT_TRUE(socket.accept());
    EXPECT_FALSE(socket.accept());
  }
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(LocalSocketTest, CreatesTheLastDirectoryIfMissing) {
  auto wanted = settings();
  wanted.file.path = directory_ / "run" / "camera.sock";
  const LocalSocket socket(wanted);
  EXPECT_TRUE(std::filesystem::is_socket(wanted.file.path));
}

TEST_F(LocalSocketTest, ReplacesTheSocketOfADeadPredecessor) {
  const pid_t child = ::fork();
  if (child == 0) {
    const LocalSocket dead(settings());
    ::_exit(0);  // without its destructor
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  ASSERT_TRUE(std::filesystem::is_socket(path_));
  const LocalSocket socket(settings());
  EXPECT_TRUE(connect_to(path_));
}

TEST_F(LocalSocketTest, ErrorsNameThePathAndTheFix) {
  scratch_.write("camera.sock", "precious");
  EXPECT_THAT(refusal(settings()), HasSubstr("camera.sock: exists and is not a socket; remove it"));
  EXPECT_EQ(tools::contents(path_), "precious");
  auto wanted = settings();
  wanted.file.path = directory_ / std::string(200, 'x');
  EXPECT_THAT(refusal(wanted), HasSubstr("is too long for a socket"));
  wanted.file.path = directory_ / "a" / "b" / "camera.sock";
  wanted.fix = "try --socket";
  EXPECT_THAT(refusal(wanted), HasSubstr("is missing and cannot be created"));
  EXPECT_THAT(refusal(wanted), HasSubstr("; create it, or try --socket"));
  wanted.file.path = "/proc/camera.sock";  // where even root cannot create a file
  EXPECT_THAT(refusal(wanted), StartsWith("/proc/camera.sock: cannot be created: "));
  EXPECT_THAT(refusal(wanted), EndsWith("; try --socket"));
  wanted = settings();
  wanted.file.group = "no-such-group-here";
  EXPECT_THAT(refusal(wanted), HasSubstr("there is no group \"no-such-group-here\""));
}

TEST_F(LocalSocketTest, AdmitsOurOwnUser) {
  const LocalSocket socket(settings());
  const FileDescriptor camera = connect_to(path_);
  const auto connection = socket.accept();
  ASSERT_TRUE(connection);
  EXPECT_TRUE(peer_is_welcome(connection.get(), 12345, 0600));
  EXPECT_THAT(peer_of(connection.get()), testing::FieldsAre(::getpid(), ::geteuid(), ::getegid()));
}

// Only root can change its user to test this.
TEST_F(LocalSocketTest, AdmitsOtherUsersOnlyByGroupOrMode) {
  if (::geteuid() != 0) {
    std::puts("not run: 1 (needs root)");
    return;
  }
  constexpr uid_t nobody = 65534;
  const LocalSocket open(settings(0666));
  auto closed_settings = settings(0660);
  closed_settings.file.path = directory_ / "closed.sock";
  const LocalSocket closed(closed_settings);
  const pid_t child = ::fork();
  if (child == 0) {
    const bool dropped = ::setgid(nobody) == 0 && ::setuid(nobody) == 0;
    const bool refused = !connect_to(closed_settings.file.path);
    const FileDescriptor connected = connect_to(path_);
    ::_exit(dropped && refused && connected ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_FALSE(closed.accept());
  const auto connection = open.accept();
  ASSERT_TRUE(connection);
  EXPECT_EQ(peer_of(connection.get()).uid, nobody);
  EXPECT_FALSE(peer_is_welcome(connection.get(), 12345, 0660));
  EXPECT_TRUE(peer_is_welcome(connection.get(), 12345, 0666));
  EXPECT_TRUE(peer_is_welcome(connection.get(), nobody, 0660));
}

}  // namespace
}  // namespace odomd::daemon::local_socket_test
