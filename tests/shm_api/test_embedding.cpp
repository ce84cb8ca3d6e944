// The library inside other programs: loaded at run time, inherited by a fork, used by another
// thread. test_stress.cpp has clients in several threads.
#include <dlfcn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <memory>
#include <stdexcept>
#include <thread>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_embedding {
namespace {

constexpr std::int64_t second = 1'000'000'000;

// A pose was returned. Whether it is fresh depends on the load of the machine.
bool is_given(odom_status status) {
  return status == ODOM_OK || status == ODOM_STALE;
}

class Embedding : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  Writer writer{{.name = path, .slots = 64}, test_info(second)};
};

struct CloseLibrary {
  void operator()(void* library) const noexcept { dlclose(library); }
};

template <class Function>
Function* symbol(void* library, const char* name) {
  void* const found = dlsym(library, name);
  if (found == nullptr) throw std::runtime_error(dlerror());
  return reinterpret_cast<Function*>(found);
}

TEST_F(Embedding, ALibraryLoadedAtRunTimeReadsAndCanBeUnloaded) {
  publish_patterned(writer, 1, 100);
  for (int time = 0; time < 2; ++time) {
    const std::unique_ptr<void, CloseLibrary> library(dlopen(ODOMD_LIBODOM, RTLD_NOW | RTLD_LOCAL));
    ASSERT_NE(library, nullptr) << dlerror();
    auto* open = symbol<decltype(odom_open)>(library.get(), "odom_open");
    auto* latest = symbol<decltype(odom_latest)>(library.get(), "odom_latest");
    auto* close = symbol<decltype(odom_close)>(library.get(), "odom_close");

    odom_client* client = nullptr;
    ASSERT_EQ(open(path.c_str(), &client), ODOM_OK);
    odom_pose pose{};
    EXPECT_TRUE(is_given(latest(client, &pose, sizeof pose)));
    EXPECT_TRUE(is_whole(pose));
    close(client);
  }
}

TEST_F(Embedding, AfterAForkParentAndChildHaveAClientEach) {
  publish_patterned(writer, 1, 100);
  const ClientPointer client = open_client(path);
  odom_pose pose{};
  ASSERT_TRUE(is_given(odom_latest(client.get(), &pose, sizeof pose)));
  const pid_t child = fork();
  if (child == 0) {
    // Sleeps on the futex of an inherited mapping.
    const bool fine = is_given(odom_wait(client.get(), &pose, sizeof pose, 60 * second)) &&
                      pose.tick == 2 && is_whole(pose);
    odom_client* inherited = client.get();
    odom_close(inherited);
    _exit(fine ? 0 : 1);
  }
  ASSERT_GT(child, 0);
  writer.set_heartbeat(now_ns());
  publish_patterned(writer, 2, 200);
  writer.wake_clients();
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  // The child has unmapped only its own mapping. Another thread may have the client, too.
  std::thread([&] { EXPECT_TRUE(is_given(odom_latest(client.get(), &pose, sizeof pose))); }).join();
  EXPECT_EQ(pose.tick, 2U);
}

}  // namespace
}  // namespace odomd::shm::testing::test_embedding
