#include "tools/live/status_values.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "tools/cli/text.hpp"

namespace odomd::tools {

const Json& member(const Json& object, const std::string& key) {
  static const Json null;
  const auto found = object.find(key);
  return found == object.end() ? null : *found;
}

const Json& namesake(const Json& array, const Json& name) {
  static const Json null;
  for (const auto& element : array) {
    if (member(element, "name") == name) return element;
  }
  return null;
}

std::string number(const Json& value, int decimals, double factor) {
  return value.is_null() ? "-" : fixed(factor * value.get<double>(), decimals);
}

std::string significant(const Json& value) {
  return value.is_null() ? "-" : fmt::format("{:#.3g}", value.get<double>());
}

std::string count(const Json& value) {
  return value.is_null() ? "-" : std::to_string(value.get<std::uint64_t>());
}

std::string counted(const Json& value, std::string_view noun) {
  return value.is_null() ? "- " + std::string{noun} + 's'
                         : counted(value.get<std::uint64_t>(), noun);
}

std::string word(const Json& value) {
  return value.is_null() ? "-" : value.get<std::string>();
}

bool is_true(const Json& value) {
  return !value.is_null() && value.get<bool>();
}

std::string duration(const Json& value) {
  if (value.is_null()) return "never";
  const double s = value.get<double>();
  if (s < 1.0) return fixed(1e3 * s, 1) + " ms";
  if (s < 120.0) return fixed(s, 1) + " s";
  const auto minutes = static_cast<long>(s / 60.0);
  if (minutes < 120) return std::to_string(minutes) + " min";
  const std::string rest = std::to_string(minutes % 60);
  return std::to_string(minutes / 60) + " h " + (rest.size() < 2 ? "0" : "") + rest + " min";
}

std::string source_state(const Json& source) {
  if (is_true(member(source, "healthy")))
    return is_true(member(source, "inconsistent")) ? "inconsistent" : "fine";
  // Missing or impossible values come before other findings.
  constexpr std::array first{"timed_out", "failed_protection", "out_of_range", "non_finite",
                             "frozen"};
  std::string flag = word(member(source, "flag"));
  std::string wiring = word(member(source, "wiring"));
  std::ranges::replace(wiring, '_', ' ');
  if (wiring != "-" && wiring != "ok" && std::ranges::find(first, flag) == first.end())
    return "miswired: " + wiring;
  if (flag == "-" || flag == "ok" || flag == "timed_out") return "overdue";
  std::ranges::replace(flag, '_', ' ');
  return flag;
}

std::string hexadecimal(const Json& value) {
  return value.is_null() ? "-" : fmt::format("0x{:X}", value.get<std::uint64_t>());
}

std::uint64_t sum(const Json& counts) {
  std::uint64_t total = 0;
  for (const auto& value : counts) total += value.get<std::uint64_t>();
  return total;
}

bool is_tested(const Json& sources) {
  return std::any_of(sources.begin(), sources.end(), [](const Json& source) {
    return !member(member(source, "innovations"), "mean_nis").is_null();
  });
}

std::string nis_by_expectation(const Json& innovations) {
  const Json& dimension = member(innovations, "dimension");
  if (dimension.is_null() || dimension.get<int>() == 0) return "-";
  return number(member(innovations, "mean_nis"), 2, 1.0 / dimension.get<double>());
}

std::string percent_inside(const Json& innovations) {
  return number(member(innovations, "inside_95"), 1, 100.0);
}

std::vector<Calibration> calibrations_of(const Json& now) {
  struct Shown {
    std::string_view name;
    std::string_view unit;
    double factor;
  };
  constexpr std::array with_unit{
      Shown{"gyro_bias", " deg/s", degrees}, Shown{"accel_bias_x", " m/s2", 1.0},
      Shown{"accel_bias_y", " m/s2", 1.0},   Shown{"steering_offset", " deg", degrees},
      Shown{"gyro_latency", " ms", 1e3},     Shown{"wheel_latency", " ms", 1e3},
      Shown{"steering_latency", " ms", 1e3}, Shown{"grip", " m/s2", 1.0}};
  std::vector<Calibration> all;
  for (const auto& calibration : member(now, "calibrations")) {
    if (member(calibration, "sigma").is_null()) continue;
    const std::string name = word(member(calibration, "name"));
    const auto* const found = std::ranges::find(with_unit, name, &Shown::name);
    const Shown shown = found != with_unit.end() ? *found : Shown{name, "", 1.0};
    all.push_back({name, number(member(calibration, "value"), 4, shown.factor),
                   number(member(calibration, "sigma"), 4, shown.factor), std::string{shown.unit},
                   is_true(member(calibration, "valid"))});
  }
  return all;
}

Rates::Rates(const Json& now, const std::optional<Json>& before) {
  const double up = member(now, "uptime_s").is_null() ? 0.0 : now.at("uptime_s").get<double>();
  seconds_ = up;
  if (!before || member(*before, "instance") != member(now, "instance")) return;
  const auto& earlier = member(*before, "uptime_s");
  if (earlier.is_null() || !(up > earlier.get<double>())) return;
  before_ = *before;
  seconds_ = up - earlier.get<double>();
}

std::string Rates::of(const Json& now, const Json& then) const {
  if (now.is_null()) return "-";
  return of(now.get<std::uint64_t>(), then.is_null() ? 0 : then.get<std::uint64_t>());
}

std::string Rates::of(std::uint64_t now, std::uint64_t then) const {
  if (!(seconds_ > 0.0) || now < then) return "-";
  return fixed(static_cast<double>(now - then) / seconds_, 1);
}

}  // namespace odomd::tools
