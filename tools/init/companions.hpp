// Signals next to a measured one, in its message: whether it is valid, and its sign.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"

namespace odomd::tools {

struct Companion {
  const can::Signal* signal = nullptr;
  /// The physical value that means "valid", or "negative". None: only a log shows it.
  std::optional<double> value;
};

/// Found by name ("YawRate_Stat", "QBit_YawRate", "IMU_Valid") and by the names of the values.
[[nodiscard]] std::vector<Companion> validity_of(const can::Message& message,
                                                 const can::Signal& measured);

/// Found by name ("VZ_YawRate", "YawRateSign", "YawRate_Dir"), for a signal without a sign.
[[nodiscard]] std::optional<Companion> sign_of(const can::Message& message,
                                               const can::Signal& measured);

/// Raw values that the database names as invalid.
[[nodiscard]] std::vector<std::int64_t> invalid_raws(const can::Signal& measured);

/// Sets the value of a validity signal: the most frequent one in the log's second half; without a
/// log it is the database's or none. A log that contradicts the database leaves none, with a
/// warning.
void settle(Companion& companion, std::span<const double> seen, std::vector<std::string>& warnings);

}  // namespace odomd::tools
