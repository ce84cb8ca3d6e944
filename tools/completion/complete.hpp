// Lists what a shell may offer for the last word of a command line. This is the hidden command
// `odom complete PROGRAM WORD...`, which the scripts in this folder call.
#pragma once

#include <span>
#include <string>

namespace odomd::completion {

/// Writes a line for each candidate, whether it fits the last word or not: the word, a tab, its
/// help; ":files" and ":directories" ask the shell for those. The first of `words` is the program,
/// odom or odomd; other programs have no candidates.
void complete(std::span<const std::string> words);

}  // namespace odomd::completion
