// The results of tuning, as text and JSON.
#pragma once

#include <string>

#include "tools/tune/tuning.hpp"

namespace odomd::tools {

/// Keys before and after with their fates, every drive before and after, and a verdict.
[[nodiscard]] std::string as_text(const TuneJob& job, const TuneResult& result);

/// One JSON object with its newline; SI units. A trial that was impossible has the error null.
[[nodiscard]] std::string as_json(const TuneResult& result);

/// One row per trial: the keys' values and the relative error, "inf" where it was impossible.
[[nodiscard]] std::string trials_csv(const TuneJob& job, const TuneResult& result);

/// "odom tune: 12.3 % better on 3 drives, 4.5 % on 2 held out": the note after a written number.
[[nodiscard]] std::string note_of(const TuneJob& job, const TuneResult& result,
                                  const TunedKey& key);

}  // namespace odomd::tools
