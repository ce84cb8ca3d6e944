#include "tools/bridge/bridge.hpp"

#include <cmath>
#include <cstdlib>
#include <regex>
#include <stdexcept>

#include "tools/cli/command.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

std::string problem_of_name(const std::string& text) {
  constexpr std::size_t longest = 255;
  const bool has_blanks = text.find_first_of(" \t\n") != std::string::npos;
  if (!text.empty() && text.size() <= longest && !has_blanks) return "";
  return tools::quoted(text) +
         " is not a frame name: letters without blanks, at most 255 bytes, such as base_link";
}

std::string problem_of_topic(const std::string& text) {
  static const std::regex topic("(/[A-Za-z_][A-Za-z0-9_]*)+");
  if (text.size() < 250 && std::regex_match(text, topic)) return "";
  return tools::quoted(text) +
         " is not a topic with its namespace, such as /pose or /mocap/car/pose";
}

void describe_input(Command command, BridgeOptions& options) {
  PoseInput& input = options.input;
  command.add("--pose-topic", "TOPIC", input.topic,
              "Send the car's pose from this ROS 2 topic to the daemon as camera poses: "
              "PoseWithCovarianceStamped, PoseStamped or Odometry",
              {checked(problem_of_topic)});
  command.add("--pose-frame", "NAME", input.frame,
              "Frame of these poses; others are refused; default: that of --frame-map",
              {checked(problem_of_name), needs("--pose-topic")});
  command.add("--pose-child-frame", "NAME", input.child_frame,
              "Child frame of an Odometry on the topic; others are refused; default: base_link",
              {checked(problem_of_name), needs("--pose-topic")});
  command.add("--pose-sigma", "SX,SY,SYAW", input.sigma,
              "Minimum standard uncertainty of these poses, also used for poses that state none "
              "[m, m, rad]; default: 0.01 each",
              {delimiter(','), values(3), positive(), needs("--pose-topic")});
  add_socket_option(command, input.socket, "camera");
  command.add_flag("--no-publish", options.no_publish, "Only receive --pose-topic",
                   {needs("--pose-topic"), excludes("--ros"), excludes("--udp")});
}

}  // namespace

void describe_bridge(Command command, BridgeOptions& options) {
  command.description(
      "Publish the pose for other programs (ROS 2 topics, JSON over UDP), or receive it");
  command.add_flag("--ros", options.ros,
                   "ROS 2 topics /odom and /tf over DDS; default if no other output is given");
  command.add("--udp", "HOST:PORT", options.udp,
              "Send JSON to this address, for PlotJuggler; default address: 127.0.0.1:9870",
              {value_if_none(plotjuggler_address)});
  add_segment_option(command, options.shm);
  command.add("--rate", "HZ", options.rate_hz,
              "Poses per second [Hz], at most one per tick; default: 50", {positive()});
  command.add("--domain", "N", options.domain,
              "DDS domain, 0 to 232; default: $ROS_DOMAIN_ID, or 0");
  command.add_choice("--frame", options.frame, {{"odom", PoseFrame::odom}, {"map", PoseFrame::map}},
                     "Frame of the pose in /odom; default: odom");
  command.add_choice(
      "--tf", options.transforms,
      {{"all", Transforms::all}, {"odom", Transforms::odom}, {"none", Transforms::none}},
      "Transforms on /tf: map to odom to base, only odom to base, or none; default: all");
  command.add("--frame-map", "NAME", options.names.map, "Name of the map's frame; default: map",
              {checked(problem_of_name)});
  command.add("--frame-odom", "NAME", options.names.odom,
              "Name of the odometry frame; default: odom", {checked(problem_of_name)});
  command.add("--frame-base", "NAME", options.names.base,
              "Name of the car's frame, at its centre of gravity; default: base_link",
              {checked(problem_of_name)});
  describe_input(command, options);
  command.add("--duration", "S", options.duration_s, "End after this time [s]", {positive()});
  command.add_flag("--json", options.json, "Print the summary as JSON on standard output");
  command.footer(
      "Examples:\n"
      "  odom bridge\n"
      "  odom bridge --domain 7 --rate 100 --frame-base cog\n"
      "  odom bridge --udp\n"
      "  odom bridge --ros --udp 192.168.1.20:9870\n"
      "  odom bridge --pose-topic /vrpn_mocap/car/pose --pose-frame world\n"
      "It waits for the daemon, and again when the daemon restarts. On a terminal, it shows once\n"
      "per second what it sends. INT and TERM end it; it then prints a summary on standard\n"
      "error. docs/bridge.md describes the topics.");
}

void complete(BridgeOptions& options) {
  const FrameNames& names = options.names;
  if (names.map == names.odom || names.odom == names.base || names.base == names.map)
    throw std::invalid_argument(
        "--frame-map, --frame-odom, --frame-base: two frames of one name; give each its own");
  PoseInput& input = options.input;
  if (input.frame.empty()) input.frame = names.map;
  if (options.publishes_ros() && input.topic == "/odom")
    throw std::invalid_argument(
        "--pose-topic /odom: the bridge publishes there; the daemon must not measure its own pose");
}

std::uint32_t domain_of(const BridgeOptions& options) {
  constexpr std::uint32_t largest = 232;  // a larger domain's ports exceed 16 bits
  const char* const environment = std::getenv("ROS_DOMAIN_ID");
  const bool named = !options.domain.empty();
  const std::string text = named ? options.domain : environment != nullptr ? environment : "";
  if (text.empty()) return 0;
  const auto domain = parse_number<std::uint32_t>(text);
  if (!domain || *domain > largest)
    throw std::invalid_argument((named ? "--domain " : "$ROS_DOMAIN_ID ") + tools::quoted(text) +
                                ": not a domain; a number from 0 to 232");
  return *domain;
}

}  // namespace odomd::tools
