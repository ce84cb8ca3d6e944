// Any text as a camera log gives finite poses or an error of one line.
#include "tools/drive_files/drive_tables.hpp"

#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return odomd::fuzz::read_file(data, size, [](const std::string& path) {
    for (const auto& warning : odomd::tools::read_camera_log(path).warnings)
      odomd::fuzz::require_one_line(text_of(warning));
  });
}
