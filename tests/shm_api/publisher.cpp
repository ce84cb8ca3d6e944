// A writer as a process, for the tests that kill it.
//   shm_publisher PATH PERIOD_NS [pause-us]
// Publishes patterned poses until it is killed, as fast as it can or with pauses.
#include <cstdlib>
#include <ctime>
#include <exception>
#include <iostream>

#include "tests/shm_api/segment_fixture.hpp"

int main(int argc, char** argv) {
  namespace shm = odomd::shm;
  if (argc < 3) return 2;
  try {
    const std::int64_t period = std::strtoll(argv[2], nullptr, 10);
    const long pause_us = argc > 3 ? std::strtol(argv[3], nullptr, 10) : 0;
    shm::Writer writer({.name = argv[1], .slots = 64}, shm::testing::test_info(period));
    const timespec pause{0, pause_us * 1000};
    for (std::uint64_t tick = 1;; ++tick) {
      const std::int64_t now = shm::testing::now_ns();
      shm::testing::publish_patterned(writer, tick, now);
      writer.set_heartbeat(now);
      if (pause_us == 0) continue;
      writer.wake_clients();
      nanosleep(&pause, nullptr);
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
