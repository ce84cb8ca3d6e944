// An axis: which numbers stand along it, and where a value lies.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace odomd::tools::chart {

enum class Scaling : std::uint8_t { linear, logarithmic };

struct Range {
  double low = 0.0;
  double high = 1.0;

  [[nodiscard]] double width() const { return high - low; }
};

/// The axis between two ends of the picture (user units; `from` belongs to the low end).
struct Scale {
  Range range;
  Scaling scaling = Scaling::linear;
  double from = 0.0;
  double to = 1.0;

  /// Values that a logarithm does not take, and such as lie far outside, come to lie near the ends.
  [[nodiscard]] double operator()(double value) const;
};

struct Tick {
  double value = 0.0;
  std::string label;  ///< with a true minus
};

/// Round numbers within the range, about `count` of them; of a logarithmic axis 1, 2 and 5 times
/// the powers of ten, or fewer.
[[nodiscard]] std::vector<Tick> ticks(const Range& range, Scaling scaling, double count);

/// 1, 2 or 5 times a power of ten, for about `count` steps over `length`.
[[nodiscard]] double round_step(double length, double count);

/// A range with some room, wide enough to be drawn: one of no width is given some.
[[nodiscard]] Range with_room(Range range, Scaling scaling);

/// As many decimals as steps of this size need.
[[nodiscard]] int decimals_for(double step);

/// A number with a true minus.
[[nodiscard]] std::string number(double value, int decimals);

}  // namespace odomd::tools::chart
