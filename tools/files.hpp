// Opens files for reading and writing, or says in one line why that cannot be.
#pragma once

#include <filesystem>
#include <fstream>

namespace odomd::tools {

/// Throws std::invalid_argument: "x.csv: no such file", "x.csv: is a directory, not a file", ...
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);

/// Opens a file for writing. Throws std::invalid_argument where that cannot be.
[[nodiscard]] std::ofstream open_output(const std::filesystem::path& file);

/// Flushes and closes; throws std::runtime_error when something could not be written.
void close_output(std::ofstream& output, const std::filesystem::path& file);

}  // namespace odomd::tools
