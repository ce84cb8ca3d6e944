// The error message of our programs if their segment is truncated.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <thread>

#include "shm_api/cut_short.hpp"
#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_cut_short {
namespace {

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

TEST(CutShort, IsSaidOnceHoweverManyThreadsSeeIt) {
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
}  // namespace odomd::shm::testing::test_cut_short
