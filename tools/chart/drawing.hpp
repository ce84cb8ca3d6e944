// Drawn pictures, put one below the other into an SVG document, for a page or a file.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace odomd::tools::chart {

struct Drawing {
  std::string name;  ///< in a few words, for those who cannot see it
  std::string svg;   ///< elements in user units, canvas wide, from y = 0 down
  double height = 0.0;
};

/// A title, to stand above others.
[[nodiscard]] Drawing heading(const std::string& text);

/// One `<svg>` element with the drawings one below the other, on white.
[[nodiscard]] std::string as_svg(std::span<const Drawing> drawings);

/// Writes .svg, or .png by the program rsvg-convert. Throws std::invalid_argument for another
/// ending or a file that cannot be written, std::runtime_error when the conversion fails.
void write_picture(const std::filesystem::path& file, std::span<const Drawing> drawings);

/// For use before long work: throws std::invalid_argument if write_picture() would.
void check_picture(const std::filesystem::path& file);

}  // namespace odomd::tools::chart
