// Any file as a log gives frames or an error of one line.
#include <array>
#include <string>

#include "can_protocol/sources/log_reader.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const odomd::fuzz::MemoryFile file(data, size);
  odomd::can::BusNames buses;
  try {
    const std::array<std::string, 2> paths{file.path(), file.path()};
    odomd::can::MergedLog log(paths, buses);
    while (const auto* frame = log.next())
      odomd::fuzz::require(frame->bus < odomd::can::max_buses, "the bus has a number");
    for (const std::string& warning : log.warnings()) odomd::fuzz::require_one_line(warning);
  } catch (const odomd::can::LogError& error) {
    odomd::fuzz::require_one_line(error.what());
  }
  return 0;
}
