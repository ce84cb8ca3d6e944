// The output of every method of odom identify: a table or JSON on standard output, warnings on
// standard error, and, if requested, the numbers in a configuration.
#pragma once

#include <optional>
#include <string>

#include "tools/cli/command.hpp"
#include "tools/identify/common/finding.hpp"

namespace odomd::tools {

struct Delivery {
  bool json = false;
  std::string write;   ///< the configuration to patch; empty: none
  bool force = false;  ///< replace values there that are more precise
};

/// Adds --json, --write and --force to a method.
void add_delivery(Command method, Delivery& delivery);

/// For use before the work: throws if the configuration to patch does not exist or cannot be
/// written.
void check(const Delivery& delivery);

/// A number in a configuration with the uncertainty that an earlier method noted beside it; sigma
/// 0: there is no note. Nothing if the key is missing.
[[nodiscard]] std::optional<Measured> measured_in(const std::string& file, const std::string& key);

/// Prints, then patches the configuration and lists the keys on standard error. A value there whose
/// note states a smaller uncertainty is kept, with a warning, unless forced. Throws if the
/// configuration cannot be patched; it is then unchanged.
void deliver(Findings findings, const Delivery& delivery);

/// The table: name, value ± 2 sigma, unit, per cent, key, remark.
[[nodiscard]] std::string as_text(const Findings& findings);
[[nodiscard]] nlohmann::ordered_json as_json(const Findings& findings);

}  // namespace odomd::tools
