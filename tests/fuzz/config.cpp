// Any text as a configuration gives values in range or an error of one line.
#include "daemon/core/config.hpp"

#include <stdexcept>

#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const odomd::fuzz::MemoryFile file(data, size);
  try {
    const odomd::daemon::Config config = odomd::daemon::load_config(file.path());
    odomd::fuzz::require(config.vehicle.mass > 0.0, "the car weighs something");
    odomd::fuzz::require(config.realtime.period_ns > 0, "time moves on");
  } catch (const std::invalid_argument& error) {
    odomd::fuzz::require_one_line(error.what());
  }
  return 0;
}
