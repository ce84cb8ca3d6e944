// odom identify track: hands over to the program odom-track, which alone is linked with OpenCV.
#include <memory>

#include "tools/cli/companion.hpp"
#include "tools/identify/methods.hpp"
#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

void add_track(Command identify) {
  auto options = std::make_shared<TrackOptions>();
  Command method = identify.add_subcommand("track");
  describe_track(method, *options);
  method.callback([method, options] {
    check(*options);
    become("odom-track", method.given(),
           "films need odom-track: install the package odom-track, or libopencv-dev, and configure "
           "and build again; odom identify stiffness also accepts tracks of other programs");
  });
}

}  // namespace odomd::tools
