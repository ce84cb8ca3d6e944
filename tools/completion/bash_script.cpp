#include "tools/completion/scripts.hpp"

#include <fmt/format.h>

namespace odomd::completion {
namespace {

// The shell code that offers values.
std::string offer(const std::string& program, const ValueSpec& value) {
  switch (value.values) {
    case Values::file:
      return "_" + program + "_files";
    case Values::directory:
      return "_" + program + "_directories";
    case Values::interface:
      return "_" + program + "_words \"$(_" + program + "_interfaces)\"";
    case Values::source:
      return "_" + program + "_files; _" + program + "_words \"- $(_" + program + "_interfaces)\"";
    case Values::segment:
      return "_" + program + "_files; _" + program + "_words \"$(_" + program + "_segments)\"";
    case Values::choice:
      return "_" + program + "_words \"" + joined(value.choices, " ") + "\"";
    default:
      return ":";
  }
}

std::string helpers(const std::string& program) {
  std::string text = R"sh(
_@_words() {
  COMPREPLY+=($(compgen -W "$1" -- "$cur"))
}

_@_files() {
  compopt -o filenames 2>/dev/null
  local IFS=$'\n'
  COMPREPLY+=($(compgen -f -- "$cur"))
}

_@_directories() {
  compopt -o filenames 2>/dev/null
  local IFS=$'\n'
  COMPREPLY+=($(compgen -d -- "$cur"))
}

# Network devices of type 280 are those of the CAN bus.
_@_interfaces() {
  local device
  for device in /sys/class/net/*; do
    [ "$(cat "$device/type" 2>/dev/null)" != 280 ] || echo "${device##*/}"
  done
}

_@_segments() {
  local file
  for file in /dev/shm/*; do
    [ ! -f "$file" ] || [[ $file == *.lock ]] || echo "${file#/dev/shm}"
  done
}
)sh";
  for (auto at = text.find('@'); at != std::string::npos; at = text.find('@', at))
    text.replace(at, 1, program);
  return text;
}

}  // namespace

std::string bash_script(const CommandSpec& program) {
  const std::string& name = program.path.front();
  const auto commands = all_commands(program);
  std::string below;
  for (const CommandSpec* command : commands)
    if (command->path.size() > 1)
      below += (below.empty() ? "" : " | ") + ('"' + joined(command->path, " ") + '"');

  std::string text = "# bash completion for " + name +
                     ", generated from its command line. Do not edit.\n" + helpers(name);
  text += "\n_" + name + "() {\n  local cur=${COMP_WORDS[COMP_CWORD]}" +
          " prev=${COMP_WORDS[COMP_CWORD - 1]}\n  local command=" + name + " i\n  COMPREPLY=()\n";
  if (!below.empty()) {
    text +=
        "  for ((i = 1; i < COMP_CWORD; i++)); do\n    case \"$command ${COMP_WORDS[i]}\" in\n     "
        " " +
        below + ")\n        command+=\" ${COMP_WORDS[i]}\" ;;\n    esac\n  done\n";
  }
  text += "  # The value of an option.\n  case \"$command $prev\" in\n";
  for (const CommandSpec* command : commands) {
    for (const OptionSpec& option : command->options) {
      if (option.value.values == Values::none) continue;
      std::string places;
      for (const std::string& option_name : option.names)
        places += (places.empty() ? "" : " | ") +
                  ('"' + joined(command->path, " ") + ' ' + option_name + '"');
      text += fmt::format("    {})\n      {}; return ;;\n", places, offer(name, option.value));
    }
  }
  text += "  esac\n  case $command in\n";
  for (const CommandSpec* command : commands) {
    std::string words;
    for (const CommandSpec& sub : command->commands) words += sub.path.back() + ' ';
    for (const OptionSpec& option : command->options) words += joined(option.names, " ") + ' ';
    if (!words.empty()) words.pop_back();
    text += "    \"" + joined(command->path, " ") + "\")\n";
    // Offer options only after the arguments.
    for (const ValueSpec& argument : command->arguments)
      text += "      [[ $cur == -?* ]] || { " + offer(name, argument) + "; }\n";
    text += fmt::format("      _{}_words \"{}\" ;;\n", name, words);
  }
  return text + "  esac\n} && complete -F _" + name + ' ' + name + '\n';
}

}  // namespace odomd::completion
