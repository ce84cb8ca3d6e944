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
  std::string_view to_file;  ///< the command that unpacks a file beside it
  std::string_view to_pipe;  ///< the one that unpacks it to standard output
};

/// The packing of a file that begins so; nullptr: none that is known.
[[nodiscard]] const Packing* packing_of(std::string_view head) noexcept;

/// "a directory", "a named pipe", "a pipe", "a socket" or "a device"; empty for a regular file and
/// for one that does not exist.
[[nodiscard]] std::string_view kind_of_no_file(const std::filesystem::path& file);

/// Why a file cannot be read as text, with the fix: "is a named pipe; name a file"; else empty. A
/// pipe without a name, such as <(command) of a shell, can be read.
[[nodiscard]] std::string problem_with_input(const std::filesystem::path& file);

}  // namespace odomd
