// Any text as a camera log gives finite poses or an error of one line.
#include "tools/drive_files/camera_csv.hpp"

#include <stdexcept>
#include <string>

#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const odomd::fuzz::MemoryFile file(data, size);
  try {
    const odomd::tools::CameraLog log = odomd::tools::read_camera_log(file.path());
    for (const auto& warning : log.warnings) odomd::fuzz::require_one_line(text_of(warning));
  } catch (const std::invalid_argument& error) {
    odomd::fuzz::require_one_line(error.what());
  }
  return 0;
}
