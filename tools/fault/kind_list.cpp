#include "tools/fault/kind_list.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/fault/kinds.hpp"

namespace odomd::fault {
namespace {

constexpr std::size_t width = 100;

std::vector<Kind> kinds_of(Part part) {
  std::vector<Kind> kinds;
  std::ranges::copy_if(all_kinds(), std::back_inserter(kinds),
                       [part](Kind kind) { return kind.part == part; });
  return kinds;
}

std::string size_text(Magnitude size) {
  if (size.unit == "x") return fmt::format("x {}", size.value);
  return fmt::format("{} {}", size.value, size.unit);
}

// "0.2 rad/s, 3 m/s2": the sizes for all parts, each once.
std::string sizes_of(Act act) {
  std::vector<std::string> sizes;
  for (const Kind kind : all_kinds()) {
    if (kind.act != act || default_magnitude(kind).unit.empty()) continue;
    const std::string size = size_text(default_magnitude(kind));
    if (std::ranges::find(sizes, size) == sizes.end()) sizes.push_back(size);
  }
  std::string text;
  for (const std::string& size : sizes) text += (text.empty() ? "" : ", ") + size;
  return text;
}

void append_ways(std::string& text, Part part) {
  constexpr std::string_view indent = "    ";
  std::string line(indent);
  for (const Kind kind : kinds_of(part)) {
    const std::string_view name = info(kind.act).name;
    if (line.size() + name.size() + 1 > width) {
      text += line + '\n';
      line = indent;
    }
    if (line.size() > indent.size()) line += ' ';
    line += name;
  }
  text += line + '\n';
}

}  // namespace

std::string kinds_text() {
  std::string text =
      "A kind of fault is PART.WAY, such as gyro.frozen.\n\nParts and their ways to fail:\n";
  for (const PartInfo& part : parts()) {
    text += fmt::format("  {}: {}\n", part.name, part.what);
    append_ways(text, part.part);
  }
  text += "\nWays to fail, with the default size:\n";
  for (const ActInfo& act : acts()) {
    const std::string sizes = sizes_of(act.act);
    text +=
        fmt::format("  {:<19} {}{}\n", act.name, act.what, sizes.empty() ? "" : " (" + sizes + ")");
  }
  return text;
}

nlohmann::ordered_json kinds_json() {
  auto all = nlohmann::ordered_json::array();
  for (const Kind kind : all_kinds()) {
    const Magnitude size = default_magnitude(kind);
    auto sources = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < estimator::source_count; ++i)
      if (contains(sources_of(kind), static_cast<estimator::Source>(i)))
        sources.push_back(estimator::source_names[i]);
    nlohmann::ordered_json one{{"kind", name_of(kind)},
                               {"part", info(kind.part).what},
                               {"what", info(kind.act).what},
                               {"size", nullptr},
                               {"unit", nullptr},
                               {"sources", std::move(sources)}};
    if (!size.unit.empty()) {
      one["size"] = size.value;
      one["unit"] = size.unit;
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace odomd::fault
