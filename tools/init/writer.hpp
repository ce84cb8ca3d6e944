// The proposal as a commented car.toml, as a table for people and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "can_protocol/decode/signal_binding.hpp"
#include "tools/init/car.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

struct Draft {
  Proposal proposal;
  Car car;
  std::vector<can::E2eBinding> protections;
  std::vector<std::string> databases;  ///< as the configuration names them
  std::vector<std::string> sources;    ///< interfaces
  std::string made_from;               ///< "car.dbc and drive.log"
};

/// A number of the vehicle and its origin.
struct VehicleValue {
  std::string key;
  double value = 0.0;
  std::string origin;
  bool sure = true;
};

/// The keys of [vehicle]. Unknown numbers are typical of the class, and marked as not sure.
[[nodiscard]] std::vector<VehicleValue> vehicle_values(const Draft& draft);

[[nodiscard]] std::string as_toml(const Draft& draft);
[[nodiscard]] std::string as_text(const Draft& draft);
[[nodiscard]] nlohmann::ordered_json as_json(const Draft& draft);

}  // namespace odomd::tools
