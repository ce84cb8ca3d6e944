// The table of faults: the parts of a car that fail, and their ways to fail. A kind is a part and a
// way, "gyro.frozen".
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estimator/common/measurement.hpp"

namespace odomd::fault {

/// A set of sources: bit s is estimator::Source s.
using Sources = std::uint32_t;

[[nodiscard]] constexpr Sources only(estimator::Source source) noexcept {
  return 1U << estimator::index_of(source);
}
[[nodiscard]] constexpr bool contains(Sources sources, estimator::Source source) noexcept {
  return (sources & only(source)) != 0;
}

enum class Part : std::uint8_t {
#define ODOMD_PART(name, ...) name,
#include "tools/fault/kinds.inc"
};

struct PartInfo {
  Part part;
  std::string_view name;
  std::string_view what;
  Sources sources;
};
[[nodiscard]] std::span<const PartInfo> parts() noexcept;

enum class Act : std::uint8_t {
#define ODOMD_ACT(name, ...) name,
#include "tools/fault/kinds.inc"
};

/// The default size of a fault and its unit: "rad/s", "s", "x" (a factor), "sigma" (times the
/// stated one), "share" (of the frames); empty if it has no size.
struct Magnitude {
  double value = 0.0;
  std::string_view unit;
};

struct ActInfo {
  Act act;
  std::string_view name;
  std::string_view what;
  Magnitude magnitude;  ///< empty where it depends on the part, too: default_magnitude()
};
[[nodiscard]] std::span<const ActInfo> acts() noexcept;

struct Kind {
  Part part = Part::gyro;
  Act act = Act::frozen;
  bool operator==(const Kind&) const = default;
};

/// Every part in every way that it can fail.
[[nodiscard]] const std::vector<Kind>& all_kinds();

[[nodiscard]] const PartInfo& info(Part part) noexcept;
[[nodiscard]] const ActInfo& info(Act act) noexcept;

/// "gyro.frozen"
[[nodiscard]] std::string name_of(Kind kind);
/// Throws std::invalid_argument that names the nearest kind.
[[nodiscard]] Kind parse_kind(std::string_view name);

[[nodiscard]] Magnitude default_magnitude(Kind kind) noexcept;

/// The sources that the car must do without once the fault is known. None if the fault affects the
/// stamps of the whole bus.
[[nodiscard]] Sources sources_of(Kind kind) noexcept;

}  // namespace odomd::fault
