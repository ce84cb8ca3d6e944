// Motor controllers whose frames are published: a VESC's CAN status frames and an ODrive's CAN
// Simple. Their identifiers carry the number that the owner gives, so the database is made.
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

/// None if none is given. Throws std::invalid_argument for a number that no controller has, and for
/// more than one controller.
[[nodiscard]] std::optional<MotorController> parse_controller(const ControllerTexts& texts);

/// A database that is written next to the configuration: "vesc-23.dbc".
struct MadeDatabase {
  std::string name, text;
};
[[nodiscard]] MadeDatabase make_database(const MotorController& controller);

/// Throws std::invalid_argument if the frame with the speed is not in the traffic; names the
/// numbers that are.
void require_frames(const MotorController& controller, const Traffic& traffic);

/// Adds to the proposal what is doubtful about the controller: a gear ratio that nobody gave and
/// that nobody can be asked for is 1.
void settle_motor(Proposal& proposal, const MotorController& controller, Car& car, bool can_ask);

}  // namespace odomd::tools
