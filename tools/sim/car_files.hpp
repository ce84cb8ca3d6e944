// The texts that go with a simulated drive: the configuration that fits, and what was drawn.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tools/sim/simulation.hpp"

namespace odomd::sim {

/// How a daemon will get at the drive.
struct Wiring {
  std::string can = "drive.log";        ///< [can] source: interface, log or "-"
  std::filesystem::path camera_socket;  ///< empty: the daemon's default
};

/// car.toml: the configuration of the simulated car, as its owner would write it; it knows nothing
/// of the errors drawn.
[[nodiscard]] std::string configuration_text(const RunPlan& plan, const Wiring& wiring);

/// plant.json: the run, the sizes of its errors, and the errors themselves.
[[nodiscard]] nlohmann::ordered_json describe(const RunPlan& plan);

}  // namespace odomd::sim
