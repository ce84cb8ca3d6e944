#include "tools/completion/scripts.hpp"

#include <fmt/format.h>

namespace odomd::completion {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result + '\'';
}

// The part of a `complete` that offers values.
std::string offer(const std::string& program, const ValueSpec& value) {
  switch (value.values) {
    case Values::none:
      return "";
    case Values::file:
    case Values::directory:
      return " -r -F";
    case Values::interface:
      return " -x -a '(__" + program + "_interfaces)'";
    case Values::source:
      return " -r -F -a '(__" + program + "_interfaces)'";
    case Values::segment:
      return " -r -F -a '(__" + program + "_segments)'";
    case Values::choice:
      return " -x -a '" + joined(value.choices, " ") + "'";
    case Values::free:
      return " -x";
  }
  return "";
}

std::string option_names(const OptionSpec& option) {
  std::string text;
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return text;
}

}  // namespace

std::string fish_script(const CommandSpec& program) {
  const std::string& name = program.path.front();
  std::string text = "# fish completion for " + name +
                     ", generated from its command line. Do not edit.\n\n"
                     "function __" +
                     name +
                     "_interfaces\n    echo -\n    for device in /sys/class/net/*\n"
                     "        # those of the CAN bus\n"
                     "        if test \"$(cat $device/type 2>/dev/null)\" = 280\n"
                     "            basename $device\n        end\n    end\nend\n\n"
                     "function __" +
                     name +
                     "_segments\n    for file in /dev/shm/*\n        if test -f $file\n"
                     "            and not string match -q '*.lock' $file\n"
                     "            echo /(basename $file)\n        end\n    end\nend\n\n"
                     "function __" +
                     name + "_command\n    set -l command " + name +
                     "\n    for word in (commandline -opc)[2..-1]\n"
                     "        switch \"$command $word\"\n            case ";
  std::string below;
  for (const CommandSpec* command : all_commands(program))
    if (command->path.size() > 1) below += ' ' + quoted(joined(command->path, " "));
  text += (below.empty() ? "''" : below.substr(1)) +
          "\n                set command \"$command $word\"\n        end\n    end\n"
          "    echo $command\nend\n\ncomplete -c " +
          name + " -f\n";
  for (const CommandSpec* command : all_commands(program)) {
    const std::string start =
        fmt::format("complete -c {0} -n \"test '{1}' = (__{0}_command | string collect)\"", name,
                    joined(command->path, " "));
    for (const CommandSpec& sub : command->commands)
      text += fmt::format("{} -a {} -d {}\n", start, sub.path.back(), quoted(sub.help));
    for (const ValueSpec& argument : command->arguments) {
      std::string values = offer(name, argument);
      if (const auto needed = values.find(" -r"); needed != std::string::npos)
        values.erase(needed, 3);
      text += fmt::format("{}{}\n", start, values);
    }
    for (const OptionSpec& option : command->options)
      text += fmt::format("{}{}{} -d {}\n", start, option_names(option), offer(name, option.value),
                          quoted(option.help));
  }
  return text;
}

}  // namespace odomd::completion
