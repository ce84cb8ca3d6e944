// odom identify track: hands over to the program odom-track, which alone is linked with OpenCV.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/identify/methods.hpp"
#include "tools/track/options.hpp"

namespace odomd::tools {
namespace {

// Never comes back.
void become_odom_track(const TrackOptions& options) {
  check(options);
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "odom-track";
  std::vector<std::string> arguments = arguments_of(options);
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  if (errno == ENOENT)
    throw std::runtime_error(
        "films need odom-track: install the package odom-track, or libopencv-dev and build again; "
        "tracks of other programs do for odom identify stiffness too");
  throw std::runtime_error(program.string() + ": " + std::strerror(errno));
}

}  // namespace

void add_track(Command identify) {
  auto options = std::make_shared<TrackOptions>();
  Command method = identify.add_subcommand("track");
  describe_track(method, *options);
  method.callback([options] { become_odom_track(*options); });
}

}  // namespace odomd::tools
