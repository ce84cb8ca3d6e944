// odom identify fit: hands over to the program odom-fit, which alone is linked with Ceres.
#include <memory>

#include "tools/cli/companion.hpp"
#include "tools/identify/fit/options.hpp"
#include "tools/identify/methods.hpp"

namespace odomd::tools {

void add_fit(Command identify) {
  auto options = std::make_shared<FitOptions>();
  Command method = identify.add_subcommand("fit");
  describe_fit(method, *options);
  method.callback([options, method] {
    check(*options);
    become("odom-fit", method.given(),
           "fitting needs odom-fit: install the package odom-fit; or install libceres-dev, and "
           "configure and build all: cmake --preset release && cmake --build --preset release");
  });
}

}  // namespace odomd::tools
