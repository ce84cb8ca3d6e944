#include "tools/sim/drive_folder.hpp"

#include <algorithm>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "can_protocol/sources/candump.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/table.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {
namespace {

using enum Parameter;
using tools::toml_number;

// A wheel's speed is a mean over the previous cycle, so it is half a cycle old.
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

// The name of the 1:10 car is left out.
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
  std::string signals;
  for (const BusRole& role : bus_roles()) {
    const Quality q = quality(plan, role);
    signals += fmt::format(
        "{} = {{ message = \"{}\", signal = \"{}\", unit = \"{}\", sigma = {:.3g}{} }}\n",
        role.role, role.message, role.signal, role.unit, q.sigma,
        q.latency > 0.0 ? fmt::format(", latency = {:.6g}", q.latency) : "");
  }
  const std::string socket = wiring.camera_socket.string();
  return fmt::format(
      R"(# Made by odom sim: {}.

[vehicle]
mass = {}
front_axle = {}
rear_axle = {}
yaw_inertia = {}
cornering_stiffness_front = {}
cornering_stiffness_rear = {}
track_width = {}
{}
[can]
source = {}
dbc = "car.dbc"

{}
[can.signals]
{}
[camera]
{}lever_arm = [{}, {}, {}]

[reference]
lever_arm = [0.0, 0.0, 0.0]

[imu]
position = [{}, {}]

[initial]
pose = [{:.9g}, {:.9g}, {:.9g}]
)",
      made_for(plan), toml_number(car.mass), toml_number(car.front_axle),
      toml_number(car.rear_axle), toml_number(car.yaw_inertia),
      toml_number(car.cornering_stiffness_front), toml_number(car.cornering_stiffness_rear),
      toml_number(car.track_width),
      car.driven == estimator::Driven::front ? "driven = \"front\"\n" : "",
      tools::json_text(wiring.can), bus_protection_text(), signals,
      socket.empty() ? "" : fmt::format("socket = {}\n", tools::json_text(socket)),
      toml_number(plan.truth[camera_x]), toml_number(plan.truth[camera_y]),
      toml_number(plan.truth[camera_yaw]), toml_number(plan.truth[imu_x]),
      toml_number(plan.truth[imu_y]), plan.start.x, plan.start.y, plan.start.heading);
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
  const auto [front, rear] = configured_markers(plan.car_kind);
  result["markers"] = {{"front", {front.x, front.y}}, {"rear", {rear.x, rear.y}}};
  result["errors"] = plan.options.errors == ErrorModel::ideal ? "ideal" : "realistic";
  if (plan.car.suspension.present()) {
    // a_y reads (1 + g·roll_gradient) times its true value in a steady turn
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

void make_drive_folder(const std::filesystem::path& folder, Existing existing) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw std::invalid_argument(folder.string() + ": is not a directory");
  std::filesystem::create_directories(folder, error);
  if (error)
    throw std::invalid_argument(folder.string() + ": cannot be created: " + error.message());
  const bool empty = std::filesystem::is_empty(folder, error);
  if (error) throw std::invalid_argument(folder.string() + ": " + error.message());
  if (!empty && existing == Existing::keep)
    throw std::invalid_argument(folder.string() +
                                ": is not empty; give another directory, or replace the drive in "
                                "it with --force");
}

void write_car_files(const std::filesystem::path& folder, const RunPlan& plan,
                     const Wiring& wiring) {
  tools::write_whole(folder / "car.dbc", bus_database_text(plan.truth));
  tools::write_whole(folder / "car.toml", configuration_text(plan, wiring));
  tools::write_whole(folder / "plant.json", describe(plan).dump(2) + "\n");
}

DriveWriter::DriveWriter(const std::filesystem::path& folder, std::string interface,
                         FilmMarkers film)
    : folder_(folder),
      interface_(std::move(interface)),
      log_(tools::open_output(folder / "drive.log")),
      camera_(tools::open_output(folder / "camera.csv")),
      truth_(tools::open_output(folder / "truth.csv")) {
  camera_ << tools::header_of<estimator::CameraPose>(tools::camera_columns);
  truth_ << tools::header_of<tools::TrajectoryPoint>(tools::point_columns);
  if (film == FilmMarkers::leave_out) return;
  film_ = tools::open_output(folder / "markers.csv");
  film_ << "t,x_front,y_front,x_rear,y_rear\n";
}

void DriveWriter::write(const Happenings& happenings) {
  text_.clear();
  for (const can::Frame& frame : happenings.frames)
    can::append_candump_line(text_, frame, interface_);
  log_ << text_;

  text_.clear();
  for (const estimator::CameraPose& pose : happenings.camera)
    append_row(text_, tools::camera_columns, pose, 6);
  camera_ << text_;

  text_.clear();
  for (const tools::TrajectoryPoint& row : happenings.truth)
    append_row(text_, tools::point_columns, row, 7);  // a tenth of a micrometre suffices
  truth_ << text_;

  text_.clear();
  for (const FilmFrame& frame : happenings.film) {
    text_ += tools::fixed(frame.t_s, 6);
    for (const auto& marker : frame.markers) {
      if (!marker) {
        text_ += ",,";
        continue;
      }
      for (const double value : *marker) tools::append_number(text_ += ',', value, 3);
    }
    text_ += '\n';
  }
  if (film_.is_open()) film_ << text_;
  if (!film_ || !log_ || !camera_ || !truth_)
    throw std::runtime_error(folder_.string() + ": cannot be written to; is the disk full?");
}

void DriveWriter::close() {
  tools::close_output(log_, folder_ / "drive.log");
  tools::close_output(camera_, folder_ / "camera.csv");
  tools::close_output(truth_, folder_ / "truth.csv");
  if (film_.is_open()) tools::close_output(film_, folder_ / "markers.csv");
}

}  // namespace odomd::sim
