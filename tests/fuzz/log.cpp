// Any file as a log gives frames or an error of one line.
#include <array>

#include "can_protocol/sources/log_reader.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return odomd::fuzz::read_file<odomd::can::LogError>(data, size, [](const std::string& path) {
    odomd::can::BusNames buses;
    const std::array paths{path, path};
    odomd::can::MergedLog log(paths, buses);
    while (const auto* frame = log.next())
      odomd::fuzz::require(frame->bus < odomd::can::max_buses, "the bus has a number");
    for (const std::string& warning : log.warnings()) odomd::fuzz::require_one_line(warning);
  });
}
