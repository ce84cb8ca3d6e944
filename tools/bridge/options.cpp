#include "tools/bridge/options.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "tools/bridge/sink.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/daemon_options.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

const Choices<PoseFrame>& frames() {
  static const Choices<PoseFrame> names{{"odom", PoseFrame::odom}, {"map", PoseFrame::map}};
  return names;
}

const Choices<Transforms>& transforms() {
  static const Choices<Transforms> names{
      {"all", Transforms::all}, {"odom", Transforms::odom}, {"none", Transforms::none}};
  return names;
}

std::string problem_of_rate(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc{} && stopped == end && value > 0.0 && std::isfinite(value)) return "";
  return tools::quoted(text) + " is not a finite number greater than 0";
}

std::string problem_of_name(const std::string& text) {
  constexpr std::size_t longest = 255;
  const bool has_blanks = text.find_first_of(" \t\n") != std::string::npos;
  if (!text.empty() && text.size() <= longest && !has_blanks) return "";
  return tools::quoted(text) +
         " is not a frame name: letters without blanks, at most 255 bytes, such as base_link";
}

}  // namespace

void describe_bridge(Command command, BridgeOptions& options) {
  command.description("Publish the pose for other programs: ROS 2 topics, JSON over UDP");
  command.add_flag("--ros", options.ros,
                   "ROS 2 topics /odom and /tf by DDS; default if no other output is given");
  command
      .add("--udp", "HOST:PORT", options.udp,
           "JSON to this address, for PlotJuggler; default address: 127.0.0.1:9870")
      .value_if_none(plotjuggler_address);
  add_segment_option(command, options.shm);
  command
      .add("--rate", "HZ", options.rate_hz,
           "Poses per second, at most every tick [Hz]; default: 50")
      .check(problem_of_rate);
  command.add("--domain", "N", options.domain, "DDS domain, 0 to 232; else $ROS_DOMAIN_ID, or 0");
  add_choice(command, "--frame", options.frame, frames(),
             "Frame of the pose in /odom; default: odom");
  add_choice(command, "--tf", options.transforms, transforms(),
             "Transforms on /tf: map to odom to base, odom to base alone, none; default: all");
  command.add("--frame-map", "NAME", options.names.map, "Name of the map's frame; default: map")
      .check(problem_of_name);
  command
      .add("--frame-odom", "NAME", options.names.odom, "Name of the odometry frame; default: odom")
      .check(problem_of_name);
  command
      .add("--frame-base", "NAME", options.names.base,
           "Name of the car's frame, at its centre of gravity; default: base_link")
      .check(problem_of_name);
  command.add("--duration", "S", options.duration_s, "End after this time [s]").positive();
  command.add_flag("--json", options.json, "Print the summary as JSON on standard output");
  command.footer(
      "Examples:\n"
      "  odom bridge\n"
      "  odom bridge --domain 7 --rate 100 --frame-base cog\n"
      "  odom bridge --udp\n"
      "  odom bridge --ros --udp 192.168.1.20:9870\n"
      "It waits for the daemon and reconnects when that restarts. On a terminal it shows once a\n"
      "second what it sends. INT and TERM end it, with a summary on standard error.\n"
      "docs/bridge.md describes the topics.");
}

std::vector<std::string> arguments_of(const BridgeOptions& options) {
  std::vector<std::string> arguments{"--ros", "--rate", shortest(options.rate_hz)};
  const auto add = [&arguments](const char* name, const std::string& value) {
    if (value.empty()) return;
    arguments.emplace_back(name);
    arguments.push_back(value);
  };
  add("--udp", options.udp);
  add("--shm", options.shm);
  add("--domain", options.domain);
  for (const auto& [name, frame] : frames())
    if (frame == options.frame) add("--frame", name);
  for (const auto& [name, wanted] : transforms())
    if (wanted == options.transforms) add("--tf", name);
  add("--frame-map", options.names.map);
  add("--frame-odom", options.names.odom);
  add("--frame-base", options.names.base);
  if (options.duration_s > 0.0) add("--duration", shortest(options.duration_s));
  if (options.json) arguments.emplace_back("--json");
  return arguments;
}

void check_names(const FrameNames& names) {
  if (names.map != names.odom && names.odom != names.base && names.base != names.map) return;
  throw std::invalid_argument(
      "--frame-map, --frame-odom, --frame-base: two frames of one name; give each its own");
}

std::uint32_t domain_of(const BridgeOptions& options) {
  constexpr std::uint32_t largest = 232;  // its ports would not fit into 16 bits
  const char* const environment = std::getenv("ROS_DOMAIN_ID");
  const bool named = !options.domain.empty();
  const std::string text = named ? options.domain : environment != nullptr ? environment : "";
  if (text.empty()) return 0;
  std::uint32_t domain = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, domain);
  if (error != std::errc{} || stopped != end || domain > largest)
    throw std::invalid_argument((named ? "--domain " : "$ROS_DOMAIN_ID ") + tools::quoted(text) +
                                ": not a domain; a number from 0 to 232");
  return domain;
}

}  // namespace odomd::tools
