// The progress of a run on standard error: one line that is updated on a terminal, one line per
// second elsewhere.
#pragma once

#include <cstdint>
#include <string>

#include "tools/sim/simulation.hpp"

namespace odomd::sim {

enum class ShowProgress : std::uint8_t { automatic, always, never };

/// "12.3 s, 8.1 of 82.2 m (10 %), 1.50 m/s"
[[nodiscard]] std::string progress_text(const Simulation& simulation);

class Progress {
 public:
  /// Automatic: on a terminal only, where `otherwise` is never.
  Progress(ShowProgress show, ShowProgress otherwise);

  /// Call as often as you like; shows ten times a second on a terminal.
  void update(const Simulation& simulation);

  /// Ends the line.
  void finish(const Simulation& simulation);

 private:
  enum class Style : std::uint8_t { silent, one_line, lines };
  void show(const Simulation& simulation);

  Style style_ = Style::silent;
  std::int64_t next_ns_ = 0;  // on the steady clock
};

}  // namespace odomd::sim
