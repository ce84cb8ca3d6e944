// Options that stand together in the help.
#pragma once

#include <string>

#include "tools/cli/command.hpp"

namespace odomd::tools {

struct OptionGroup {
  Command command;
  std::string heading;  ///< empty: none

  /// `type` is the name of the value in the help.
  template <OptionValue T>
  Option add(const std::string& name, const std::string& type, T& value,
             const std::string& help) const {
    const Option option = command.add_option(name, value, help).type_name(type);
    return heading.empty() ? option : option.group(heading);
  }
};

}  // namespace odomd::tools
