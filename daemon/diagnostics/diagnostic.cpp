#include "daemon/diagnostics/diagnostic.hpp"

#include <fmt/format.h>

namespace odomd::diagnostics {

std::string fix_of(const Diagnostic& diagnostic) {
  std::string fix{diagnostic.kind->fix};
  if (const std::size_t gap = fix.find('{'); gap != std::string::npos)
    fix.replace(gap, fix.find('}', gap) + 1 - gap, diagnostic.detail);
  return fix;
}

std::string text_of(const Diagnostic& diagnostic) {
  const std::string fix = fix_of(diagnostic);
  return fmt::format("{}{}{}{}{} [{}]", diagnostic.subject,
                     diagnostic.subject.empty() || diagnostic.seen.empty() ? "" : ": ",
                     diagnostic.seen, fix.empty() ? "" : "; ", fix, diagnostic.kind->code);
}

std::vector<std::string> texts_of(const Diagnostics& diagnostics) {
  std::vector<std::string> texts;
  texts.reserve(diagnostics.size());
  for (const Diagnostic& one : diagnostics) texts.push_back(text_of(one));
  return texts;
}

void append(Diagnostics& to, const Kind& kind, std::span<const std::string> lines) {
  for (const std::string& line : lines) to.push_back(found(kind, {}, line));
}

void append(Diagnostics& to, const Diagnostics& others) {
  to.insert(to.end(), others.begin(), others.end());
}

void append(Diagnostics& to, std::optional<Diagnostic> one) {
  if (one) to.push_back(*std::move(one));
}

}  // namespace odomd::diagnostics
