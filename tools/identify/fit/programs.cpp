// odom identify fit and track: separate programs, the only ones linked with large libraries.
#include <memory>
#include <string>

#include "tools/cli/command_line.hpp"
#include "tools/identify/fit/options.hpp"
#include "tools/identify/methods.hpp"
#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {
namespace {

/// `missing` is the error if the program is not installed: how to install it.
template <class Options>
void add_program(Command identify, const std::string& name, void (*describe)(Command, Options&),
                 const std::string& missing) {
  const auto options = std::make_shared<Options>();
  const Command method = identify.add_subcommand(name);
  describe(method, *options);
  method.callback([=] {
    check(*options);
    hand_over(method, "odom-" + name, missing);
  });
}

}  // namespace

void add_track(Command identify) {
  add_program(identify, "track", describe_track,
              "films need odom-track: install the package odom-track, or libopencv-dev, and "
              "configure and build again; odom identify stiffness also accepts tracks of other "
              "programs");
}

void add_fit(Command identify) {
  add_program(identify, "fit", describe_fit,
              "fitting needs odom-fit: install the package odom-fit; or install libceres-dev, and "
              "configure and build all: cmake --preset release && cmake --build --preset release");
}

}  // namespace odomd::tools
