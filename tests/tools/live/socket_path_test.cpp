// Which socket of a daemon the tools take when none is named.
#include "tools/live/daemon_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/tools/live/answering_socket.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::socket_path_test {
namespace {

using ::testing::HasSubstr;

std::string problem_of(const std::string& leaf) {
  try {
    return "found: " + socket_path({}, leaf);
  } catch (const NobodyThere& error) {
    return error.what();
  }
}

TEST(SocketPath, ANamedOneIsTakenWhetherItIsThereOrNot) {
  EXPECT_EQ(socket_path("nowhere.sock", "status.sock"), "nowhere.sock");
}

TEST(SocketPath, AnErrorNamesAllPlaces) {
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", "/run/user/4711", 1), 0);
  EXPECT_THAT(problem_of("none.sock"),
              HasSubstr("/run/user/4711/odomd/none.sock, /run/odomd/*/none.sock, "
                        "/run/odomd/none.sock: no such socket; is odomd running?"));
  ASSERT_EQ(::unsetenv("XDG_RUNTIME_DIR"), 0);
  EXPECT_THAT(problem_of("none.sock"), HasSubstr("$XDG_RUNTIME_DIR (not set), /run/odomd/*/"));
}

TEST(SocketPath, TheStatusIsThatOfTheUsersOwnDaemon) {
  const Scratch runtime;
  std::filesystem::create_directory(runtime.path("odomd"));
  const AnsweringSocket daemon{runtime.path("odomd/status.sock").string(), R"({"pid": 4711})"};
  const Outcome outcome =
      run_shell("XDG_RUNTIME_DIR=" + runtime.path("").string() + " odom status --json");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("4711"));
}

TEST(SocketPath, RecordAndCameraSendLookInTheSamePlaces) {
  const Scratch runtime;
  std::filesystem::create_directory(runtime.path("odomd"));
  const std::string own = runtime.path("").string();
  const std::string with = "XDG_RUNTIME_DIR=" + own;
  const AnsweringSocket recorder{runtime.path("odomd/record.sock").string(), "no recording"};
  EXPECT_THAT(run_shell(with + " odom record").err, HasSubstr(own + "/odomd/record.sock: "));
  const AnsweringSocket camera{runtime.path("odomd/camera.sock").string(), "no camera"};
  EXPECT_THAT(run_shell(with + " odom camera send --pose 1,2,3").err,
              HasSubstr(own + "/odomd/camera.sock: "));
}

}  // namespace
}  // namespace odomd::tools::socket_path_test
