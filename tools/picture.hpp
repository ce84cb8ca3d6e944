// Trajectories over each other as one clean SVG: light background, equal axes, readable at the
// width of a phone and in print.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace odomd::tools {

struct PicturePoint {
  double x = 0.0;  ///< [m], to the right
  double y = 0.0;  ///< [m], upwards
};

/// The region of a 2-D normal distribution within three standard deviations along each axis of it.
struct PictureEllipse {
  PicturePoint centre;
  std::array<double, 3> covariance{};  ///< xx, xy, yy [m²]
};

struct PictureTrace {
  std::string label;  ///< in the legend
  std::string note;   ///< beside it, lighter: "1.23 cm/m"
  std::vector<PicturePoint> points;
  std::optional<PictureEllipse> end_ellipse;  ///< 3σ at the end
};

struct Picture {
  std::string title;  ///< may be empty
  PictureTrace reference;
  std::vector<PictureTrace> estimates;
  std::vector<PicturePoint> dots;  ///< camera poses
  std::string dots_label;
};

/// The view covers the reference, and of the estimates what lies near it: one that runs away is cut
/// at the border and its note says so. Needs at least one point in the reference or an estimate.
[[nodiscard]] std::string draw(const Picture& picture);

/// Writes .svg, or .png by the program rsvg-convert. Throws std::invalid_argument for another
/// ending or a file that cannot be written, std::runtime_error when the conversion fails.
void write_picture(const std::filesystem::path& file, const Picture& picture);

}  // namespace odomd::tools
