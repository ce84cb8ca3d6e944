// Which signals of a database may have which role, by the words of their names, their unit and
// their size. Pure: no log is looked at (behaviour.hpp does that).
#pragma once

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
  const can::Signal* fraction = nullptr;  ///< the fine part of a coarse signal, to be added
  std::vector<Companion> valid_when;      ///< all of them; those without a value do not count
  std::optional<Companion> sign;
  std::vector<std::int64_t> unless_raw;  ///< names of values that are none
  bool all_ones = false;                 ///< seen in the log, and left out
  can::Unit unit = can::Unit::none;      ///< the database's, else the role's usual one
  double score = 0.0;                    ///< comparable within a role only
  std::vector<std::string> warnings;     ///< why name, unit or size leave it open; empty: clear
  double forward = 0.0, reverse = 0.0;   ///< of direction: physical values

  [[nodiscard]] std::string name() const { return message->name + "." + signal->name; }
};

/// "rear left wheel's speed": of a role, for people.
[[nodiscard]] std::string_view quantity_of(estimator::Source role);

/// The candidates for a role, the best first; at most `most`.
[[nodiscard]] std::vector<Candidate> candidates_for(estimator::Source role,
                                                    std::span<const can::Database> databases,
                                                    std::size_t most = 4);

}  // namespace odomd::tools
