// The options for weighings: loads, precision of the scale, gravity.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/command.hpp"
#include "tools/identify/weighing/weighing.hpp"

namespace odomd::tools {

struct ScaleOptions {
  std::array<std::vector<std::string>, static_cast<std::size_t>(Load::count)> loads;
  std::string resolution;
  std::string sigma;
  std::string accuracy;
  std::string gravity;
};

void add_scale_options(Command method, ScaleOptions& options);

struct Weighings {
  std::vector<Weighing> weighings;
  Scale scale;
  std::string origin;  ///< "scale, 6 weighings"
};

/// Throws std::invalid_argument for impossible numbers.
[[nodiscard]] Weighings weighings_of(const ScaleOptions& options);

/// The level of the car, for both methods that weigh axles.
struct LevelOptions {
  std::string height;
  std::string level = "0.25deg";
};

void add_level_options(Command method, LevelOptions& options);

/// Writes height and slope to the dimensions, which must have the wheelbase.
void set_level(const LevelOptions& options, Dimensions& dimensions);

/// A warning about the units for a mass that is only known to 2 % or worse.
[[nodiscard]] std::optional<diagnostics::Diagnostic> coarse(const Measured& mass);

/// The loads by a scale that has got the shifts of a car on slopes: so have `weighings` afterwards.
[[nodiscard]] WheelLoads loads_on_slopes(Weighings& weighings, const Dimensions& dimensions);

/// --measured, for the methods of scale, tape and stop-watch. Add it before their other options.
void add_measured_option(Command method);

/// --gravity: local, or the mean of the Earth's with the spread of it.
void add_gravity_option(Command method, std::string& gravity);
[[nodiscard]] Measured gravity_of(const std::string& gravity);

}  // namespace odomd::tools
