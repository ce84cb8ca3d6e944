// A reader as a process: shm_stress_reader SEGMENT COUNTS INDEX KIND SLOTS
// Reads until the counts' stop flag is set or its parent has ended.
#include <sys/prctl.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <iostream>

#include "tests/shm_api/stress.hpp"

int main(int argc, char** argv) {
  namespace shm = odomd::shm::testing;
  if (argc != 6) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    const shm::SharedCounts counts(argv[2]);
    const auto index = std::strtoull(argv[3], nullptr, 10) % shm::SharedCounts::capacity;
    const auto kind = static_cast<shm::ReaderKind>(std::strtoul(argv[4], nullptr, 10));
    shm::read_on(argv[1], kind, std::strtoull(argv[5], nullptr, 10), counts->readers[index],
                 counts->stop);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
