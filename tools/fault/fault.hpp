// Faults: which part of a car fails and how (together the kind, "gyro.frozen"), when, and by how
// much.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "estimator/common/source.hpp"

namespace odomd::fault {

using estimator::contains, estimator::only, estimator::Sources;

/// The names of the sources, in their order.
[[nodiscard]] std::vector<std::string_view> names_of(Sources sources);

enum class Part : std::uint8_t {
#define ODOMD_PART(name, ...) name,
#include "tools/fault/kinds.inc"
};

/// Groups of parts that can fail in the same ways, as bits.
using Groups = std::uint32_t;

/// The default sizes of faults of one quantity, with their units.
struct FaultSizes {
  std::string_view unit;
  std::string_view rate_unit;
  double stuck;
  double bias;
  double ramp;  ///< per second
};

struct PartInfo {
  Part part;
  std::string_view name;
  std::string_view what;
  Sources sources;
  Groups groups;
  FaultSizes quantity;  ///< empty for parts that have none or several
};

enum class Act : std::uint8_t {
#define ODOMD_ACT(name, ...) name,
#include "tools/fault/kinds.inc"
};

/// The default size of a fault and its unit: "rad/s", "s", "x" (a factor), "sigma" (times the
/// stated sigma), "share" (of the frames); empty if it has no size.
struct Magnitude {
  double value = 0.0;
  std::string_view unit;
};

struct ActInfo {
  Act act;
  std::string_view name;
  std::string_view what;
  Groups groups;        ///< parts of these groups can fail in this way
  Magnitude magnitude;  ///< empty if it depends on the part, too: default_magnitude()
};

struct FaultKind {
  Part part = Part::gyro;
  Act act = Act::frozen;
  bool operator==(const FaultKind&) const = default;
};

/// Every part with each of its ways to fail.
[[nodiscard]] const std::vector<FaultKind>& all_kinds();

[[nodiscard]] const PartInfo& info(Part part) noexcept;
[[nodiscard]] const ActInfo& info(Act act) noexcept;

/// "gyro.frozen"
[[nodiscard]] std::string name_of(FaultKind kind);
/// Throws std::invalid_argument that names the nearest kind.
[[nodiscard]] FaultKind parse_kind(std::string_view name);

[[nodiscard]] Magnitude default_magnitude(FaultKind kind) noexcept;

/// The sources that the car must do without once the fault is known. None for a fault of the whole
/// bus.
[[nodiscard]] Sources sources_of(FaultKind kind) noexcept;

struct Fault {
  FaultKind kind;
  double begin_s = 0.0;                                         ///< after the first frame
  double duration_s = std::numeric_limits<double>::infinity();  ///< infinite: to the end
  double magnitude = 0.0;                                       ///< see default_magnitude()
  std::uint64_t seed = 1;                                       ///< seed of its random parts
};

/// A fault with the kind's default size, from the first frame to the end.
[[nodiscard]] Fault fault_of(FaultKind kind);

/// "KIND[:BEGIN[:LENGTH[:SIZE]]]", times in seconds; omitted or empty fields are as in fault_of().
/// Throws std::invalid_argument that names the wrong field.
[[nodiscard]] Fault parse_fault(std::string_view text);

/// Throws std::invalid_argument for a time or a size that the kind cannot have.
void check(const Fault& fault);

/// The time in which a fault acts, on the drive's clock: begin_ns <= t < end_ns.
struct ActiveTime {
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;

  [[nodiscard]] bool holds(std::int64_t time_ns) const noexcept {
    return begin_ns <= time_ns && time_ns < end_ns;
  }
};

/// `start_ns`: the stamp of the drive's first frame.
[[nodiscard]] inline ActiveTime span_of(const Fault& fault, std::int64_t start_ns) noexcept {
  constexpr double longest_s = 1e9;
  const std::int64_t begin_ns = start_ns + std::llround(fault.begin_s * 1e9);
  const bool ends = fault.duration_s < longest_s;
  return {begin_ns, ends ? begin_ns + std::llround(fault.duration_s * 1e9)
                         : std::numeric_limits<std::int64_t>::max()};
}

/// The parts that can fail, their ways to fail, and the default size of each fault.
[[nodiscard]] std::string kinds_text();
/// An array with an object for every kind: kind, part, what, size, unit, sources.
[[nodiscard]] nlohmann::ordered_json kinds_json();

}  // namespace odomd::fault
