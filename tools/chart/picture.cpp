// Writes a picture to a file: SVG directly, PNG with rsvg-convert.

#include "tools/chart/picture.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {
namespace {

std::string new_temporary_file() {
  std::string name = (std::filesystem::temp_directory_path() / "odom-XXXXXX.svg").string();
  const int descriptor = ::mkstemps(name.data(), 4);
  if (descriptor < 0)
    throw std::system_error(errno, std::generic_category(), "temporary file " + name);
  ::close(descriptor);
  return name;
}

void convert(std::string svg, const std::filesystem::path& png) {
  std::string program = "rsvg-convert";
  std::string output = "--output=" + std::filesystem::absolute(png).string();
  const std::array<char*, 4> arguments{program.data(), output.data(), svg.data(), nullptr};
  pid_t child = 0;
  // posix_spawnp returns the error
  const int error =
      ::posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ);
  const std::string not_installed =
      png.string() + ": rsvg-convert is not installed; install librsvg2-bin, or give a .svg file";
  if (error == ENOENT) throw std::runtime_error(not_installed);
  if (error != 0) throw std::system_error(error, std::generic_category(), "rsvg-convert");
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "rsvg-convert");
  }
  // If fork and exec are separate, a missing program ends the child with 127 (POSIX).
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) throw std::runtime_error(not_installed);
  if (status != 0) {
    throw std::runtime_error(png.string() + ": rsvg-convert failed; give a .svg file instead");
  }
}

}  // namespace

Drawing heading(const std::string& text) {
  return {text,
          svg::words(border, border + 40.0, 40.0,
                     fmt::format(R"(font-weight="bold" fill="{}")", ink), svg::escaped(text)),
          border + 48.0};
}

std::vector<Drawing> in_pairs(std::span<const Drawing> drawings) {
  std::vector<Drawing> rows;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    const bool left = i % 2 == 0;
    if (left) rows.emplace_back();
    Drawing& row = rows.back();
    row.name += (left ? "" : "; ") + drawings[i].name;
    row.svg += fmt::format("<g transform=\"translate({} 0) scale(0.5)\">\n{}</g>\n",
                           svg::px(left ? 0.0 : 0.5 * canvas), drawings[i].svg);
    row.height = std::max(row.height, 0.5 * drawings[i].height);
  }
  return rows;
}

std::string as_svg(std::span<const Drawing> drawings) {
  std::string inside;
  std::string name;
  double height = 0.0;
  for (const Drawing& drawing : drawings) {
    name += (name.empty() ? "" : "; ") + drawing.name;
    inside += height == 0.0 ? drawing.svg
                            : fmt::format("<g transform=\"translate(0 {})\">\n{}</g>\n",
                                          svg::px(height), drawing.svg);
    height += drawing.height;
  }
  return fmt::format(
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" )svg"
      R"svg(role="img" aria-label="{2}" font-family="'DejaVu Sans', Verdana, Arial, sans-serif">
<rect width="100%" height="100%" fill="#FFFFFF"/>
{3}</svg>
)svg",
      svg::px(canvas), svg::px(height), svg::escaped(name), inside);
}

void check_picture(const std::filesystem::path& file) {
  if (file != "-" && file.extension() != ".svg" && file.extension() != ".png") {
    throw std::invalid_argument(file.string() + ": pictures end in .svg or .png; rename it");
  }
  check_writable(file);
}

void write_picture(const std::filesystem::path& file, std::span<const Drawing> drawings) {
  check_picture(file);
  if (file.extension() != ".png") {
    write_whole(file, as_svg(drawings));
    return;
  }
  const std::string svg = new_temporary_file();
  const std::unique_ptr<const char, int (*)(const char*)> removed_at_the_end(svg.c_str(), ::unlink);
  write_whole(svg, as_svg(drawings));
  convert(svg, file);
}

}  // namespace odomd::tools::chart

namespace odomd::tools::svg {

std::string px(double value) {
  return fixed(value, 1);
}

std::string escaped(const std::string& text) {
  // A round trip through JSON replaces bytes that are not UTF-8.
  constexpr std::string_view markup = "&<>\"";
  constexpr std::array entities{"&amp;", "&lt;", "&gt;", "&quot;"};
  std::string out;
  for (const char c : nlohmann::json::parse(json_text(text)).get<std::string>()) {
    if (const std::size_t at = markup.find(c); at != std::string_view::npos)
      out += entities[at];
    else
      out += static_cast<unsigned char>(c) < ' ' && c != '\n' ? ' ' : c;
  }
  return out;
}

std::string line(const std::string& data, const std::string& colour, double stroke) {
  return fmt::format(
      R"(<path d="{}" fill="none" stroke="{}" stroke-width="{}" stroke-linejoin="round" )"
      R"(stroke-linecap="round"/>)"
      "\n",
      data, colour, px(stroke));
}

std::string disc(double x, double y, double radius, const std::string& fill,
                 const std::string& stroke, double stroke_width) {
  return fmt::format(R"(<circle cx="{}" cy="{}" r="{}" fill="{}" stroke="{}" stroke-width="{}"/>)"
                     "\n",
                     px(x), px(y), px(radius), fill, stroke, px(stroke_width));
}

std::string words(double x, double y, double size, const std::string& attributes,
                  const std::string& content) {
  return fmt::format(R"(<text x="{}" y="{}" font-size="{}" {}>{}</text>)"
                     "\n",
                     px(x), px(y), px(size), attributes, content);
}

}  // namespace odomd::tools::svg
