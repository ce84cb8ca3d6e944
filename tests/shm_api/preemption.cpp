// A reader of higher real-time priority on the writer's own CPU: shm_preemption [PREEMPTIONS]
//
// The writer publishes without pause; the reader wakes at random instants, often in the middle of a
// slot that the writer then cannot finish before the reader sleeps again. Every read must return at
// its first attempt, with a complete pose. For comparison, the first time the reader also waits for
// the half-written slot, as a reader of a single-slot sequence lock would have to; it would never
// end. A third thread, of still higher priority, ends the program with status 1 when a read hangs.
// Needs SCHED_FIFO; with real-time throttling off (kernel.sched_rt_runtime_us = -1) nothing else
// would set the writer free.
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <random>
#include <stdexcept>
#include <thread>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/attach.h"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing {
namespace {

struct Result {
  std::atomic<std::uint64_t> wakeups{0};
  std::uint64_t amid = 0;   // wake-ups with a half-written slot
  std::uint64_t again = 0;  // reads that needed a second attempt
  std::uint64_t torn = 0;
  bool stuck = true;  // while the reader waited, the slot stayed half-written
};

void become(int priority, int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  const sched_param parameters{.sched_priority = priority};
  if ((cpu >= 0 && pthread_setaffinity_np(pthread_self(), sizeof set, &set) != 0) ||
      pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0)
    throw std::runtime_error("no SCHED_FIFO here: run it as root");
}

void sleep_for_us(std::uint64_t microseconds) {
  const timespec pause{0, static_cast<long>(microseconds) * 1000};
  nanosleep(&pause, nullptr);
}

// The slot after the head; its sequence is odd while the writer writes it.
const std::uint64_t* slot_at_work(const odomi_segment& segment) {
  const std::uint64_t tick = odomi_tick(odomi_read_head(segment.words)) + 1;
  return segment.slots + (tick & segment.slot_mask) * segment.slot_words;
}

// Waits for a millisecond like a reader of a single-slot sequence lock.
bool stays_odd(const std::uint64_t* slot) {
  const std::uint64_t sequence = odomi_load(slot);
  const std::int64_t end = now_ns() + 1'000'000;
  while (now_ns() < end)
    if (odomi_load(slot) != sequence) return false;
  return true;
}

void read(odom_client* client, const odomi_segment& segment, Result& result) {
  const std::uint64_t* slot = slot_at_work(segment);
  if (odomi_load(slot) % 2 == 1 && result.amid++ < 10) result.stuck &= stays_odd(slot);

  odom_view view{};
  if (odom_begin(client, &view) > ODOM_STALE) throw std::runtime_error("no pose");
  const std::uint64_t tick = odom_view_word(&view, ODOM_WORD_TICK);
  const std::uint64_t last = odom_view_word(&view, ODOM_WORD_JUMP_YAW);
  if (odom_validate(&view) == 0) ++result.again;
  if (last != pattern(tick, ODOM_WORD_JUMP_YAW - 1)) ++result.torn;

  odom_pose pose{};
  odom_details details{};
  if (odom_latest_details(client, &pose, sizeof pose, &details, sizeof details) > ODOM_STALE ||
      !is_whole(pose, &details))
    ++result.torn;
}

int run(std::uint64_t wanted) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  Writer writer({.name = path, .slots = 64}, test_info());
  publish_patterned(writer, 1, 1);
  const ClientPointer client = open_client(path);
  const odomi_owners owners{{geteuid()}, 1};
  odomi_segment segment{};
  if (odomi_attach(path.c_str(), &owners, nullptr, &segment) != ODOM_OK)
    throw std::runtime_error("cannot attach");

  become(30, -1);
  const int cpu = static_cast<int>(std::thread::hardware_concurrency()) - 1;
  Result result;
  std::atomic<bool> stop{false};
  std::thread reading([&] {
    become(20, cpu);
    std::mt19937_64 random(1);
    while (result.wakeups < wanted) {
      sleep_for_us(20 + random() % 100);
      read(client.get(), segment, result);
      ++result.wakeups;
    }
    stop = true;
  });
  std::thread writing([&] {
    become(10, cpu);
    for (std::uint64_t tick = 2; !stop.load(std::memory_order_relaxed); ++tick) {
      publish_patterned(writer, tick, static_cast<std::int64_t>(tick));
      if (tick % 64 == 0) writer.set_heartbeat(now_ns());
    }
  });

  std::uint64_t before = 0;
  for (int idle = 0; !stop;) {
    sleep_for_us(100'000);
    idle = result.wakeups == before ? idle + 1 : 0;
    before = result.wakeups;
    if (idle < 200) continue;
    std::cout << "preemption: a read hangs" << std::endl;
    std::_Exit(1);
  }
  reading.join();
  writing.join();
  odomi_detach(&segment);
  std::cout << "preemption: " << result.wakeups << " wake-ups on the writer's CPU, " << result.amid
            << " in the middle of a slot (which then " << (result.stuck ? "stayed" : "did not stay")
            << " so while waited for); " << result.again << " reads took a second attempt, "
            << result.torn << " torn\n";
  return result.amid > 0 && result.stuck && result.again == 0 && result.torn == 0 ? 0 : 1;
}

}  // namespace
}  // namespace odomd::shm::testing

int main(int argc, char** argv) {
  try {
    return odomd::shm::testing::run(argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 20'000);
  } catch (const std::exception& error) {
    std::cerr << "preemption: " << error.what() << '\n';
    return 1;
  }
}
