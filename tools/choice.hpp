// A command-line option whose value is one of a few names.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace odomd::tools {

template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

/// Adds the option `flag`, which sets `value` to what the given name stands for. Help shows the
/// names; another one is wrong usage.
template <typename T>
CLI::Option* add_choice(CLI::App& command, const std::string& flag, T& value,
                        const Choices<T>& choices, const std::string& help) {
  std::string names;
  for (const auto& choice : choices) names += (names.empty() ? "" : "|") + choice.first;
  const auto choose = [flag, &value, choices, names](const std::string& name) {
    for (const auto& choice : choices) {
      if (choice.first == name) {
        value = choice.second;
        return;
      }
    }
    throw CLI::ValidationError(flag, "\"" + name + "\" is none of " + names);
  };
  return command.add_option_function<std::string>(flag, choose, help)->type_name(names);
}

}  // namespace odomd::tools
