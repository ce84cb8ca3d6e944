#include "tools/sim/car_files.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>

#include "tools/cli/csv.hpp"
#include "tools/sim/car/cars.hpp"
#include "tools/sim/car/vehicle.hpp"

namespace odomd::sim {
namespace {

using enum Parameter;

std::string number(double value) {
  std::string text;
  tools::append_number(text, value);
  // TOML wants a point or an exponent in a float.
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

// As a person would state it.
std::string number(double value, int digits) {
  std::array<char, 32> text{};
  char* const end = std::to_chars(text.data(), text.data() + text.size(), value,
                                  std::chars_format::general, digits)
                        .ptr;
  return {text.data(), end};
}

// A basic string of TOML.
std::string quote(std::string_view text) {
  std::string result = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') result += '\\';
    result += letter;
  }
  return result + '"';
}

// A wheel's speed is a mean over the cycle before, and so half a cycle old.
struct Quality {
  double sigma;
  double latency = 0.0;
};

Quality quality(const RunPlan& plan, const BusRole& role) {
  if (role.message == "IMU")
    return {role.signal == "YawRate" ? std::max(plan.sizes[gyro_noise], 5e-4)
                                     : std::max(plan.sizes[accel_noise], 5e-3)};
  if (role.message == "STEERING") return {steering_sigma(plan.sizes)};
  const double cycle = 1e-9 * static_cast<double>(cycle_ns(plan.truth, role.message));
  const double radius = configured_wheel_radius(plan.car_kind);
  return {wheel_speed_sigma(plan.sizes, radius, cycle), 0.5 * cycle};
}

// The 1:10 car goes without a name.
std::string made_for(const RunPlan& plan) {
  const std::string car =
      is_sprung(plan.car_kind) ? "car " + std::string(car_name(plan.car_kind)) + ", " : "";
  return car + "scenario " + std::string(plan.scenario.name) + ", seed " +
         std::to_string(plan.options.seed);
}

nlohmann::ordered_json values(const ParameterSet& set) {
  nlohmann::ordered_json result;
  for (const ParameterInfo& info : parameter_table())
    result[std::string(info.name)] = set[info.parameter];
  return result;
}

}  // namespace

std::string configuration_text(const RunPlan& plan, const Wiring& wiring) {
  const estimator::Vehicle car = configured_vehicle(plan.car_kind);
  std::string text = "# Made by odom sim: " + made_for(plan) + ".\n\n[vehicle]\n";
  const auto line = [&text](std::string_view key, const std::string& value) {
    text.append(key).append(" = ").append(value).append("\n");
  };
  line("mass", number(car.mass));
  line("front_axle", number(car.front_axle));
  line("rear_axle", number(car.rear_axle));
  line("yaw_inertia", number(car.yaw_inertia));
  line("cornering_stiffness_front", number(car.cornering_stiffness_front));
  line("cornering_stiffness_rear", number(car.cornering_stiffness_rear));
  line("track_width", number(car.track_width));
  if (car.driven == estimator::Driven::front) line("driven", quote("front"));

  text += "\n[can]\n";
  line("source", quote(wiring.can));
  line("dbc", quote("car.dbc"));

  text += '\n' + bus_protection_text();

  text += "\n[can.signals]\n";
  for (const BusRole& role : bus_roles()) {
    const Quality q = quality(plan, role);
    line(role.role, "{ message = " + quote(role.message) + ", signal = " + quote(role.signal) +
                        ", unit = " + quote(role.unit) + ", sigma = " + number(q.sigma, 3) +
                        (q.latency > 0.0 ? ", latency = " + number(q.latency, 6) : "") + " }");
  }

  text += "\n[camera]\n";
  if (!wiring.camera_socket.empty()) line("socket", quote(wiring.camera_socket.string()));
  line("lever_arm", "[" + number(plan.truth[camera_x]) + ", " + number(plan.truth[camera_y]) +
                        ", " + number(plan.truth[camera_yaw]) + "]");

  text += "\n[reference]\n";
  line("lever_arm", "[0.0, 0.0, 0.0]");

  text += "\n[imu]\n";
  line("position", "[" + number(plan.truth[imu_x]) + ", " + number(plan.truth[imu_y]) + "]");

  text += "\n[initial]\n";
  line("pose", "[" + number(plan.start.x, 9) + ", " + number(plan.start.y, 9) + ", " +
                   number(plan.start.heading, 9) + "]");
  return text;
}

nlohmann::ordered_json describe(const RunPlan& plan) {
  nlohmann::ordered_json result;
  result["scenario"] = plan.scenario.name;
  result["car"] = car_name(plan.car_kind);
  result["seed"] = plan.options.seed;
  result["speed"] = plan.speed;
  result["laps"] = plan.laps;
  result["standstill"] = plan.options.ends == Ends::moving ? 0.0 : plan.options.standstill;
  result["moving_start"] = plan.options.ends == Ends::moving;
  result["route_length"] = plan.length;
  result["start_pose"] = {plan.start.x, plan.start.y, plan.start.heading};
  result["start_time_ns"] = plan.options.start_ns;
  const MarkerPlaces markers = configured_markers(plan.car_kind);
  result["markers"] = {{"front", {markers.front.x, markers.front.y}},
                       {"rear", {markers.rear.x, markers.rear.y}}};
  result["errors"] = plan.options.errors == ErrorModel::ideal ? "ideal" : "realistic";
  if (plan.car.suspension.present()) {
    // a_y reads (1 + g·roll_gradient) times what it is in a steady turn
    constexpr double degree = std::numbers::pi / 180.0;
    result["body"] = {{"roll_gradient_deg_per_g",
                       plan.car.suspension.roll_gradient() * standard_gravity / degree},
                      {"pitch_gradient_deg_per_g",
                       plan.car.suspension.pitch_gradient() * standard_gravity / degree}};
  }
  result["sizes"] = values(plan.sizes);
  result["truth"] = values(plan.truth);
  return result;
}

}  // namespace odomd::sim
