// Whether a steering angle is that of the front wheels or of the steering wheel, and their ratio.
#pragma once

#include "tools/init/drive_course.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// A steering signal without a unit that stays within one is a share of the full lock, or in
/// radians: its unit is none.
void take_command(Proposal& proposal);

/// Sets the scale of the role steering, with its reason or warning. The wheelbase must be known for
/// a ratio.
void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Known& known);

}  // namespace odomd::tools
