// Mean, rms and maximum of magnitudes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace odomd::tools {

struct Spread {
  double mean = 0.0;
  double rms = 0.0;
  double max = 0.0;
};

/// Of magnitudes as they come in.
class Gathered {
 public:
  void add(double magnitude) {
    sum_ += magnitude;
    squares_ += magnitude * magnitude;
    max_ = std::max(max_, magnitude);
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] Spread spread() const {
    const auto n = static_cast<double>(std::max<std::size_t>(count_, 1));
    return {sum_ / n, std::sqrt(squares_ / n), max_};
  }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  double max_ = 0.0;
  std::size_t count_ = 0;
};

}  // namespace odomd::tools
