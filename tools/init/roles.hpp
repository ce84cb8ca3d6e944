// Finds signals of a database that may have a role, from the words of their names, their unit and
// their size. Pure: does not look at a log (behaviour.cpp does that).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/init/companions.hpp"

namespace odomd::tools {

/// A signal that may have a role. Points into the databases.
struct Candidate {
  estimator::Source role{};
  const can::Message* message = nullptr;
  const can::Signal* signal = nullptr;
  const can::Signal* fraction = nullptr;  ///< the fine part of a coarse signal, which is added
  std::vector<Companion> valid_when;      ///< all must hold; those without a value are ignored
  std::optional<Companion> sign;
  std::optional<can::UnlessRaw> unless_raw;  ///< named by the database, or all ones in the log
  can::Unit unit = can::Unit::none;          ///< the database's, or the role's usual one
  double score = 0.0;                        ///< comparable within a role only
  std::vector<std::string> warnings;         ///< why name, unit or size are uncertain
  std::optional<double> forward, reverse;    ///< physical values; of the role direction only

  [[nodiscard]] std::string name() const { return message->name + "." + signal->name; }
};

/// The eight best candidates for a role, the best first.
[[nodiscard]] std::vector<Candidate> candidates_for(estimator::Source role,
                                                    std::span<const can::Database> databases);

}  // namespace odomd::tools
