// A command-line option whose value is one of a few names.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/cli/command.hpp"

namespace odomd::tools {

template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

/// Adds the option `flag`, which sets `value` to what the given name stands for. Help shows the
/// names; another one is wrong usage.
template <typename T>
Option add_choice(Command command, const std::string& flag, T& value, const Choices<T>& choices,
                  const std::string& help) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  return command.add_choice(
      flag, names, [&value, choices](std::size_t index) { value = choices[index].second; }, help);
}

}  // namespace odomd::tools
