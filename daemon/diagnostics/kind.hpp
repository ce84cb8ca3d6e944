// One row of the table of diagnostics: what can be wrong with a car's configuration, its sensors
// and its drives, and how to fix it.
#pragma once

#include <limits>
#include <string_view>

namespace odomd::diagnostics {

/// The usual range; a value outside it gets a diagnostic.
struct Limits {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();

  [[nodiscard]] constexpr bool hold(double value) const { return value >= least && value <= most; }
  [[nodiscard]] constexpr bool exist() const {
    return least > -std::numeric_limits<double>::infinity() ||
           most < std::numeric_limits<double>::infinity();
  }
};

constexpr Limits at_least(double value) {
  return {.least = value};
}
constexpr Limits at_most(double value) {
  return {.most = value};
}
constexpr Limits within(double least, double most) {
  return {least, most};
}

struct Kind {
  std::string_view code;     ///< "W301"; never given to another kind
  std::string_view name;     ///< "wrong_sign"
  std::string_view meaning;  ///< one sentence, for the reference page
  std::string_view fix;      ///< follows what was seen; Diagnostic::detail replaces {KEY}, {USER}
  Limits limits = {};        ///< none if the diagnostic is a plain fact
  std::string_view unit = {};
  std::string_view reason = {};  ///< for the limits: what they apply to, and why they are there
};

}  // namespace odomd::diagnostics
