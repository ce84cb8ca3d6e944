// How every method of odom identify hands over what it found: a table or JSON on standard output,
// warnings on standard error, and, where asked, the numbers into a configuration.
#pragma once

#include <string>

#include "tools/cli/command.hpp"
#include "tools/identify/common/finding.hpp"

namespace odomd::tools {

struct Delivery {
  bool json = false;
  std::string write;  ///< the configuration to patch; empty: none
};

/// Adds --json and --write to a method.
void add_delivery(Command method, Delivery& delivery);

/// Before the work: throws where there is no such configuration to patch, or it cannot be written.
void check(const Delivery& delivery);

/// Prints, then patches the configuration and tells on standard error which keys. Throws where that
/// one cannot be patched; it is then as it was.
void deliver(const Findings& findings, const Delivery& delivery);

/// The table for people: name, value ± 2 sigma, unit, per cent, key, remark.
[[nodiscard]] std::string as_text(const Findings& findings);
[[nodiscard]] nlohmann::ordered_json as_json(const Findings& findings);

}  // namespace odomd::tools
