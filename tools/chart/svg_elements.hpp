// The SVG elements used by the pictures, as text.
#pragma once

#include <string>

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
