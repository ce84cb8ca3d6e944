// Motor controllers with published frames: a VESC's CAN status frames and an ODrive's CAN Simple.
// Their identifiers contain a number that the owner sets, so the database is generated.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/init/car.hpp"

namespace odomd::tools {

/// The numbers as given with --vesc and --odrive.
struct ControllerTexts {
  std::vector<std::string> vesc, odrive;
};

struct ControllerLayout;

/// A controller on the bus.
struct MotorController {
  const ControllerLayout* layout = nullptr;
  std::uint32_t id = 0;

  [[nodiscard]] std::string name() const;  ///< "VESC 23"
};

/// Nothing if no number is given. Throws std::invalid_argument for an impossible number and for
/// more than one controller.
[[nodiscard]] std::optional<MotorController> parse_controller(const ControllerTexts& texts);

/// A database that is written next to the configuration: "vesc-23.dbc".
struct MadeDatabase {
  std::string name, text;
};
[[nodiscard]] MadeDatabase make_database(const MotorController& controller);

/// Throws std::invalid_argument if the controller's frame with the speed is not in the traffic; the
/// text names the controllers that send one.
void require_frames(const MotorController& controller, const Traffic& traffic);

/// Adds warnings about the controller to the proposal. A gear ratio that is not given and cannot be
/// asked for is 1.
void settle_motor(Proposal& proposal, const MotorController& controller, Car& car, bool can_ask);

}  // namespace odomd::tools
