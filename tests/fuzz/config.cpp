// Any text as a configuration gives values in range or an error of one line.
#include "daemon/core/config.hpp"

#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return odomd::fuzz::read_file(data, size, [](const std::string& path) {
    const odomd::daemon::Config config = odomd::daemon::load_config(path);
    odomd::fuzz::require(config.vehicle.mass > 0.0, "the mass is positive");
    odomd::fuzz::require(config.realtime.period_ns > 0, "the period is positive");
  });
}
