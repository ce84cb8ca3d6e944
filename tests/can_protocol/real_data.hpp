// Real drives and databases, which are not part of the tree: found by ODOMD_DRIVES.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

namespace odomd::can {

/// The folder, or nothing after a line that says how many cases did not run.
inline std::optional<std::filesystem::path> drives(int cases) {
  if (const char* folder = std::getenv("ODOMD_DRIVES")) return folder;
  std::printf("not run: %d\n", cases);
  return std::nullopt;
}

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace odomd::can
