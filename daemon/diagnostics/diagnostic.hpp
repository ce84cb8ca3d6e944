// A diagnostic: one thing that is wrong or implausible, as the daemon, odomd --check and the tools
// show it. Each subject has a table of kinds; those of poses, experiments, machines and buses are
// in tools (tools/diagnostics/kinds.hpp has all).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/diagnostics/kinds.hpp"

namespace odomd::diagnostics {

/// The kinds of one subject.
struct Chapter {
  std::string_view title;
  std::span<const Kind> kinds;
};

/// In the order of the codes.
inline constexpr std::array chapters{
    Chapter{"Configuration and databases", configuration},
    Chapter{"Logs and records", records},
    Chapter{"Sensors", sensors},
};

/// The kind with this name. The compiler checks that the tables have it.
[[nodiscard]] consteval const Kind& kind(std::string_view name,
                                         std::span<const Chapter> tables = chapters) {
  for (const Chapter& chapter : tables)
    for (const Kind& one : chapter.kinds)
      if (one.name == name) return one;
  throw "no such kind";
}

struct Diagnostic {
  const Kind* kind = nullptr;  ///< row of a table
  std::string subject;         ///< the source or file: "yaw_rate (IMU)", "car.toml"; may be empty
  std::string seen;            ///< what was found, with its figures
  std::string detail;          ///< replaces {KEY} or the like in the fix; may be empty
};

/// In the order in which they are shown.
using Diagnostics = std::vector<Diagnostic>;

[[nodiscard]] inline Diagnostic found(const Kind& kind, std::string subject, std::string seen,
                                      std::string detail = {}) {
  return {&kind, std::move(subject), std::move(seen), std::move(detail)};
}

/// The fix, with the detail filled in.
[[nodiscard]] std::string fix_of(const Diagnostic& diagnostic);

/// "yaw_rate (IMU): the sign is wrong compared with the other sensors; check the sign of
/// can.signals.yaw_rate.scale [W301]"
[[nodiscard]] std::string text_of(const Diagnostic& diagnostic);
[[nodiscard]] std::vector<std::string> texts_of(const Diagnostics& diagnostics);

/// One diagnostic of a kind for each line that a reader of files reports.
void append(Diagnostics& to, const Kind& kind, std::span<const std::string> lines);
void append(Diagnostics& to, const Diagnostics& others);
/// Appends the diagnostic, if there is one.
void append(Diagnostics& to, std::optional<Diagnostic> one);

}  // namespace odomd::diagnostics
