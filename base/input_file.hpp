// Recognises files that cannot be read as text: those that could block for ever or never end, and
// packed ones.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace odomd {

/// "a directory", "a named pipe", "a pipe", "a socket" or "a device"; empty for a regular file and
/// for one that does not exist.
[[nodiscard]] std::string_view kind_of_no_file(const std::filesystem::path& file);

/// Why a file cannot be read as text, with the fix: "is a named pipe; name a file"; else empty. A
/// pipe without a name, such as <(command) of a shell, can be read.
[[nodiscard]] std::string problem_with_input(const std::filesystem::path& file);

}  // namespace odomd
