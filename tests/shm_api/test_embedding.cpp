// The library inside other programs: loaded at run time, inherited by a fork, used by another
// thread (test_stress.cpp has clients in several threads). Also the error message of our programs
// when their segment is truncated.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>

#include "shm_api/cut_short.hpp"
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

TEST_F(Embedding, LibraryCanBeLoadedAtRunTimeAndUnloaded) {
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

TEST_F(Embedding, ParentAndChildEachHaveAClientAfterAFork) {
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
  // The child has unmapped only its own mapping. Another thread may use the client, too.
  std::thread([&] { EXPECT_TRUE(is_given(odom_latest(client.get(), &pose, sizeof pose))); }).join();
  EXPECT_EQ(pose.tick, 2U);
}

// A segment that is truncated while a program of ours uses it ------------------------------------

/// Two threads access a missing page at the same time. Does not return.
[[noreturn]] void read_what_is_gone(const std::string& path, int errors) {
  dup2(errors, STDERR_FILENO);
  end_where_a_segment_is_cut_short("reader");
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const void* const page = mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0);
  std::atomic<int> ready{0};
  const auto read = [&] {
    ++ready;
    while (ready < 2) continue;
    static_cast<void>(*static_cast<const volatile char*>(page));
  };
  std::thread other(read);
  read();
  _exit(0);
}

/// A full pipe, so that a write blocks.
std::array<int, 2> full_pipe() {
  std::array<int, 2> ends{};
  EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
  const std::string page(4096, '.');
  while (write(ends[1], page.data(), page.size()) > 0) continue;
  for (const int end : ends) fcntl(end, F_SETFL, 0);
  return ends;
}

std::string all_of(int file) {
  std::string text;
  std::array<char, 4096> piece{};
  for (ssize_t got = 0; (got = ::read(file, piece.data(), piece.size())) > 0;)
    text.append(piece.data(), static_cast<std::size_t>(got));
  return text.substr(text.find_first_not_of('.'));
}

TEST(CutShort, IsReportedOnceByManyThreads) {
  const TemporaryDirectory directory;
  const std::array<int, 2> errors = full_pipe();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) read_what_is_gone(directory.file("empty"), errors[1]);
  close(errors[1]);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // until both threads have failed
  EXPECT_EQ(all_of(errors[0]),
            "reader: the segment was truncated while it was in use (SIGBUS): only odomd may write "
            "to its file; start again\n");
  close(errors[0]);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace odomd::shm::testing::test_embedding
