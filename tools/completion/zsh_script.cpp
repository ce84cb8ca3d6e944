#include "tools/completion/scripts.hpp"

#include <fmt/format.h>

namespace odomd::completion {
namespace {

// Inside a quoted specification of _arguments.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result;
}

// ":value:action"
std::string action(const std::string& program, const ValueSpec& value) {
  switch (value.values) {
    case Values::none:
      return "";
    case Values::file:
      return ":file:_files";
    case Values::directory:
      return ":directory:_files -/";
    case Values::interface:
      return ":interface:_" + program + "_interfaces";
    case Values::source:
      return ":source:{_" + program + "_interfaces; _files}";
    case Values::segment:
      return ":segment:{_" + program + "_segments; _files}";
    case Values::choice:
      return ":value:(" + joined(value.choices, " ") + ")";
    case Values::free:
      return ":value: ";
  }
  return "";
}

std::string function_of(const CommandSpec& command) {
  return "_" + joined(command.path, "_");
}

// The arguments of _arguments for the options.
std::string options_of(const std::string& program, const CommandSpec& command) {
  std::string text;
  for (const OptionSpec& option : command.options) {
    const std::string what = '[' + escaped(option.help) + ']' + action(program, option.value);
    for (const std::string& name : option.names) {
      const std::string others = option.repeatable ? "*" : '(' + joined(option.names, " ") + ')';
      text += fmt::format(" \\\n    '{}{}{}'", others, name, what);
    }
  }
  return text;
}

std::string leaf(const std::string& program, const CommandSpec& command) {
  std::string text = function_of(command) + "() {\n  _arguments" + options_of(program, command);
  for (const ValueSpec& argument : command.arguments)
    text += " \\\n    '" + std::string{command.arguments.size() == 1 ? "*" : ""} +
            action(program, argument) + "'";
  return text + "\n}\n\n";
}

std::string group(const std::string& program, const CommandSpec& command) {
  std::string text = function_of(command) +
                     "() {\n  local curcontext=$curcontext state line\n  typeset -A opt_args\n"
                     "  _arguments -C" +
                     options_of(program, command) +
                     " \\\n    '1:command:->command' \\\n    '*::argument:->rest'\n"
                     "  case $state in\n    command)\n      local -a commands=(\n";
  for (const CommandSpec& sub : command.commands)
    text += fmt::format("        '{}:{}'\n", sub.path.back(), escaped(sub.help));
  text += "      )\n      _describe command commands ;;\n    rest)\n      case $line[1] in\n";
  for (const CommandSpec& sub : command.commands)
    text += fmt::format("        {}) {} ;;\n", sub.path.back(), function_of(sub));
  return text + "      esac ;;\n  esac\n}\n\n";
}

}  // namespace

std::string zsh_script(const CommandSpec& program) {
  const std::string& name = program.path.front();
  std::string text =
      "#compdef " + name + "\n# Generated from " + name +
      "'s command line. Do not edit.\n\n"
      "# Network devices of type 280 are those of the CAN bus.\n_" +
      name +
      "_interfaces() {\n  local device\n  local -a found=(-)\n"
      "  for device in /sys/class/net/*(N); do\n"
      "    [[ \"$(cat $device/type 2>/dev/null)\" != 280 ]] || found+=(${device:t})\n"
      "  done\n  compadd -- $found\n}\n\n_" +
      name +
      "_segments() {\n  local -a found=(/dev/shm/*(N.:t))\n"
      "  found=(${found:#*.lock})\n  compadd -- /$^found\n}\n\n";
  for (const CommandSpec* command : all_commands(program))
    text += command->commands.empty() ? leaf(name, *command) : group(name, *command);
  return text + "_" + name + " \"$@\"\n";
}

}  // namespace odomd::completion
