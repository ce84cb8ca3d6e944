// Matchers for diagnostics: tests check kind and figures, not the wording.
#pragma once

#include <ostream>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tests/gtest.hpp"

namespace odomd::diagnostics {

inline void PrintTo(const Diagnostic& diagnostic, std::ostream* out) {
  *out << text_of(diagnostic);
}

/// A diagnostic of this kind: `Named("wrong_sign")`.
MATCHER_P(Named, name, std::string{"is "} + name) {
  return arg.kind->name == name;
}
/// The same, with this text, such as its subject: `Named("wrong_sign", "yaw_rate")`.
MATCHER_P2(Named, name, part, std::string{"is "} + name + " with \"" + part + '"') {
  return arg.kind->name == name && text_of(arg).find(part) != std::string::npos;
}

/// The same, if its fix equals or matches `fix`:
/// `Named("no_bit_rate", "can0", HasSubstr("type can bitrate"))`.
MATCHER_P3(Named, name, part, fix,
           std::string{"is "} + name + " with \"" + part + "\" and its fix") {
  return ::testing::ExplainMatchResult(Named(name, part), arg, result_listener) &&
         ::testing::ExplainMatchResult(fix, fix_of(arg), result_listener);
}

}  // namespace odomd::diagnostics
