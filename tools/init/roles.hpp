// Finds signals of a database that may have a role, from the words of their names, their unit and
// their length, together with the signals next to them that contain their validity or sign. Logs
// are used by settle() only.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::tools {

/// A signal next to a measured one, in its message.
struct Companion {
  const can::Signal* signal = nullptr;
  /// The physical value that means "valid", or "negative"; none if only a log can show it.
  std::optional<double> value;
};

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
  std::vector<std::string> warnings;         ///< why it is uncertain: name, unit, multiplexed
  std::optional<double> forward, reverse;    ///< physical values; of the role direction only

  [[nodiscard]] std::string name() const { return message->name + "." + signal->name; }
};

/// At most eight candidates for a role, the best first.
[[nodiscard]] std::vector<Candidate> candidates_for(estimator::Source role,
                                                    std::span<const can::Database> databases);

// The signals next to a measured one (companions.cpp).

/// Found by name ("YawRate_Stat", "QBit_YawRate", "IMU_Valid") and by the names of the values.
[[nodiscard]] std::vector<Companion> validity_of(const can::Message& message,
                                                 const can::Signal& measured);

/// Found by name ("VZ_YawRate", "YawRateSign", "YawRate_Dir"), for a signal without a sign.
[[nodiscard]] std::optional<Companion> sign_of(const can::Message& message,
                                               const can::Signal& measured);

/// Raw values that the database names as invalid.
[[nodiscard]] std::vector<std::int64_t> invalid_raws(const can::Signal& measured);

/// Sets the value of a validity signal to the most frequent one in the second half of the log.
/// Without a log, the database's value is kept, if any. If the log contradicts the database, the
/// value is removed with a warning.
void settle(Companion& companion, std::span<const double> seen, std::vector<std::string>& warnings);

}  // namespace odomd::tools
