// The sigmas and biases that a log shows.
#pragma once

#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// Sets sigma where it differs from odomd's default, and the offset of a gyro that stood.
void set_noise(Proposal& proposal);

}  // namespace odomd::tools
