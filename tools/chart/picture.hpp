// The style of all pictures, and SVG documents (for a page or a file) that stack drawings. Sizes
// are user units of a canvas that is 1000 wide, so that text is legible on a phone and in print.
// The colours (Okabe and Ito) remain distinct to colour-blind readers and in grey print.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace odomd::tools::chart {

inline constexpr double canvas = 1000.0;
inline constexpr double border = 24.0;
inline constexpr double title_size = 34.0;
inline constexpr double text_size = 29.0;
inline constexpr double tick_size = 27.0;

/// Mean width of a letter / font size; generous, as fonts differ.
inline constexpr double letter_width = 0.57;

/// Six hues, then the same ones darker: their brightness differs for colour-blind readers.
inline constexpr std::array<const char*, 12> colours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                     "#56B4E9", "#8A6D00", "#003A5C", "#7A3500",
                                                     "#00513B", "#7D3F63", "#1B6A8F", "#403200"};
inline constexpr const char* reference_colour = "#A9AFB7";
inline constexpr const char* dot_colour = "#E8A100";
inline constexpr const char* refused_colour = "#C2185B";
inline constexpr const char* ink = "#1F2933";
inline constexpr const char* faint_ink = "#5F6B7A";
inline constexpr const char* grid_colour = "#E6E9ED";
inline constexpr const char* frame_colour = "#CBD2D9";

/// The colour of the i-th compared item.
[[nodiscard]] inline std::string colour_of(std::size_t i) {
  return colours[i % colours.size()];
}

struct Drawing {
  std::string name;  ///< a short description, for those who cannot see it
  std::string svg;   ///< elements in user units, canvas wide, from y = 0 down
  double height = 0.0;
};

/// A title to place above other drawings.
[[nodiscard]] Drawing heading(const std::string& text);

/// The drawings in rows of two, half as large.
[[nodiscard]] std::vector<Drawing> in_pairs(std::span<const Drawing> drawings);

/// One `<svg>` element with the drawings one below the other, on white.
[[nodiscard]] std::string as_svg(std::span<const Drawing> drawings);

/// Writes .svg, also to standard output for "-", or .png with the program rsvg-convert. Throws
/// std::invalid_argument for another ending or a file that cannot be written, std::runtime_error if
/// the conversion fails.
void write_picture(const std::filesystem::path& file, std::span<const Drawing> drawings);

/// For use before long work: throws std::invalid_argument if write_picture() would.
void check_picture(const std::filesystem::path& file);

}  // namespace odomd::tools::chart

// The SVG elements used by the pictures, as text.
namespace odomd::tools::svg {

/// A coordinate with one decimal.
[[nodiscard]] std::string px(double value);

/// Text escaped for use between tags and in attributes.
[[nodiscard]] std::string escaped(const std::string& text);

/// A stroked path; `data` is its attribute "d".
[[nodiscard]] std::string line(const std::string& data, const std::string& colour, double stroke);

[[nodiscard]] std::string disc(double x, double y, double radius, const std::string& fill,
                               const std::string& stroke, double stroke_width);

/// `content` is escaped already and may hold tspans.
[[nodiscard]] std::string words(double x, double y, double size, const std::string& attributes,
                                const std::string& content);

}  // namespace odomd::tools::svg
