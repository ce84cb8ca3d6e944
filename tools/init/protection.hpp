// End-to-end protection of odomd's own messages, and whether a log's or a bus's identifiers are
// theirs.
#pragma once

#include <span>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// Of the messages of the proposal that are those of odomd.dbc, and whose checksums are right in
/// the traffic, if there is any. A message whose checksums are wrong gives its roles a warning.
[[nodiscard]] std::vector<can::E2eBinding> protections_for(Proposal& proposal,
                                                           std::span<const can::Database> databases,
                                                           const Traffic& traffic);

/// Whether most messages of odomd.dbc come, at their full length.
[[nodiscard]] bool is_own_bus(const Traffic& traffic);

}  // namespace odomd::tools
