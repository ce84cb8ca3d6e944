// odom identify track: hands over to the program odom-track, which alone is linked with OpenCV.
#include "tools/identify/methods.hpp"
#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

void add_track(Command identify) {
  add_program(identify, "track", describe_track,
              "films need odom-track: install the package odom-track, or libopencv-dev, and "
              "configure and build again; odom identify stiffness also accepts tracks of other "
              "programs");
}

}  // namespace odomd::tools
