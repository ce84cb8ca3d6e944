// Prints every tick of a running odomd as CSV, from the history in its segment:
//
//   beat_ticks SEGMENT SECONDS
//
// It wakes only once a second and maps the segment read-only, so watching does not affect the beat.
// The first row is the oldest tick that the history still holds.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>

#include "shm_api/layout/slot.h"

namespace {

const std::uint64_t* map_segment(const std::string& name) {
  const std::string path = "/dev/shm" + name;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (file < 0 || ::fstat(file, &status) != 0)
    throw std::runtime_error(path + ": " + std::strerror(errno));
  void* memory =
      ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_SHARED, file, 0);
  ::close(file);
  if (memory == MAP_FAILED) throw std::runtime_error(path + ": " + std::strerror(errno));
  return static_cast<const std::uint64_t*>(memory);
}

/// Prints the ticks after `last`, up to the newest; returns the newest.
std::uint64_t print_ticks_after(const std::uint64_t* words, std::uint64_t last) {
  const std::uint64_t head = odomi_read_head(words);
  if (head == 0) return 0;
  const std::uint64_t newest = odomi_tick(head);
  const std::uint64_t slots = odomi_load(words + ODOM_HEADER_SLOTS);
  const std::uint64_t slot_words = odomi_load(words + ODOM_HEADER_SLOT_BYTES) / ODOM_WORD_BYTES;
  const std::uint64_t first_slot = odomi_load(words + ODOM_HEADER_BYTES) / ODOM_WORD_BYTES;
  for (std::uint64_t tick = last + 1; tick <= newest; ++tick) {
    const std::uint64_t* slot = words + first_slot + tick % slots * slot_words;
    odom_pose pose{};
    odom_details details{};
    odomi_copy_out(&pose, slot + ODOM_SLOT_POSE, ODOM_POSE_WORDS);
    odomi_copy_out(&details, slot + ODOM_SLOT_DETAILS, ODOM_DETAILS_WORDS);
    if (odomi_still(slot, odomi_sequence(tick)) == 0) continue;  // missed tick, or overwritten
    std::cout << tick << ',' << pose.time_ns << ',' << pose.mode << ',' << pose.conditions << ','
              << details.frames[0] << ',' << details.wakeup_latency_ns << ','
              << details.execution_ns << '\n';
  }
  return newest;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace std::chrono_literals;
  if (argc != 3) {
    std::cerr << "usage: beat_ticks SEGMENT SECONDS\n";
    return 2;
  }
  try {
    const std::uint64_t* words = map_segment(argv[1]);
    const int seconds = std::stoi(argv[2]);
    std::cout << "tick,time_ns,mode,conditions,frames,wakeup_latency_ns,execution_of_last_ns\n";
    std::uint64_t last = 0;
    for (int second = 0; second <= seconds; ++second) {
      if (second > 0) std::this_thread::sleep_for(1s);
      last = print_ticks_after(words, last);
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "beat_ticks: " << error.what() << '\n';
    return 1;
  }
}
