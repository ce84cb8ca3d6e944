// Recognises files that cannot be read as text: those that could block for ever or never end, and
// packed ones.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace odomd {

struct Packing {
  std::string_view begins;
  std::string_view name;     ///< "gzip"
  std::string_view to_file;  ///< command that unpacks a file into the same folder
  std::string_view to_pipe;  ///< command that unpacks a file to standard output
};

/// The packing of a file that begins with `head`; nullptr: not a known one.
[[nodiscard]] const Packing* packing_of(std::string_view head) noexcept;

/// "a directory", "a named pipe", "a pipe", "a socket" or "a device"; empty for a regular file and
/// for a missing one.
[[nodiscard]] std::string_view kind_of_no_file(const std::filesystem::path& file);

/// The reason why a file cannot be read as text, with the fix: "is a named pipe; name a file".
/// Empty if it can be read; unnamed pipes can, such as a shell's <(command).
[[nodiscard]] std::string problem_with_input(const std::filesystem::path& file);

}  // namespace odomd
