// A video of a simulated drive from above, as odom identify track reads it.
#pragma once

#include <filesystem>
#include <string>

namespace odomd::tools {

/// Renders the drive in a folder of odom sim (truth.csv, plant.json), from the film's begin and at
/// its rate there. Two ArUco markers ride on the car, 8 cm above the ground; four lie around it. A
/// camera with a lens looks down, a little askew; its calibration goes to FILM.yaml. Returns the
/// command that tracks the markers. Throws std::invalid_argument for an unusable folder.
std::string render_film(const std::filesystem::path& drive, const std::filesystem::path& film);

}  // namespace odomd::tools
