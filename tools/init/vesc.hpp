// A VESC motor controller: its CAN status frames are published, but their identifiers contain a
// number that the owner sets, so the database is generated.
#pragma once

#include <string>

#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// The database with the status frames of this VESC.
[[nodiscard]] std::string vesc_database(int id);

/// Throws std::invalid_argument if its frame with the speed is not in the traffic; the text names
/// the VESCs that send one.
void require_frames(int vesc, const Traffic& traffic);

/// Adds warnings about the VESC to the proposal. A gear ratio that is not given is 1.
void settle_motor(Proposal& proposal, int vesc, Car& car);

}  // namespace odomd::tools
