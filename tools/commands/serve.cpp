// odom serve: hands over to the program odom-web, the only one linked with an HTTP library.
#include "tools/serve/options.hpp"

#include "tools/commands/commands.hpp"

namespace odomd::tools {

void add_serve(Command odom) {
  auto options = std::make_shared<serve::Options>();
  Command command = odom.add_subcommand("serve");
  serve::describe_serve(command, *options);
  command.callback([command, options] {
    static_cast<void>(serve::endpoint_of(*options));  // errors are reported here, too
    hand_over(command, "odom-web",
              "the page needs odom-web: install the package odom-web, or libcpp-httplib-dev and "
              "build all (cmake --preset release && cmake --build --preset release); odom watch "
              "works without");
  });
}

}  // namespace odomd::tools
