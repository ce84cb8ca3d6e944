#include "tools/diagnostics/output.hpp"

#include <nlohmann/json.hpp>

#include "tools/cli/output.hpp"

namespace odomd::tools {

void warn(const std::string& command, const diagnostics::Diagnostics& diagnostics,
          const std::string& whose) {
  for (const diagnostics::Diagnostic& one : diagnostics)
    warn(command, whose + (whose.empty() ? "" : ": ") + text_of(one));
}

nlohmann::ordered_json as_json(const diagnostics::Diagnostics& diagnostics) {
  auto json = nlohmann::ordered_json::array();
  for (const diagnostics::Diagnostic& one : diagnostics)
    json.push_back({{"code", one.kind->code},
                    {"name", one.kind->name},
                    {"subject", one.subject},
                    {"seen", one.seen},
                    {"fix", fix_of(one)}});
  return json;
}

}  // namespace odomd::tools
