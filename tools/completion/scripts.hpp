// Completions for the shells, written from a command line's data.
#pragma once

#include <string>

#include "tools/completion/command_line_spec.hpp"

namespace odomd::completion {

[[nodiscard]] std::string bash_script(const CommandSpec& program);
[[nodiscard]] std::string zsh_script(const CommandSpec& program);
[[nodiscard]] std::string fish_script(const CommandSpec& program);

}  // namespace odomd::completion
