#include "tools/fault/fault.hpp"

#include <charconv>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/cli/csv.hpp"

namespace odomd::fault {
namespace {

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(':', at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

// An empty part keeps the value.
void read(std::string_view whole, std::string_view part, std::string_view what, double& value) {
  if (part.empty()) return;
  double number = 0.0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
  if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(number))
    throw std::invalid_argument(tools::quoted(whole) + ": the " + std::string(what) + " " +
                                tools::quoted(part) +
                                " is not a number; a fault is KIND:BEGIN:LENGTH:SIZE");
  value = number;
}

}  // namespace

Fault fault_of(Kind kind) {
  return {.kind = kind, .magnitude = default_magnitude(kind).value};
}

void check(const Fault& fault) {
  const std::string name = name_of(fault.kind);
  const Magnitude usual = default_magnitude(fault.kind);
  if (!(fault.begin_s >= 0.0) || !std::isfinite(fault.begin_s))
    throw std::invalid_argument(name + ": begins before the first frame; give 0 s or more");
  if (!(fault.duration_s > 0.0))
    throw std::invalid_argument(name + ": has no duration; give more than 0 s");
  if (usual.unit.empty() && fault.magnitude != usual.value)
    throw std::invalid_argument(name + ": has no size; leave it out");
  if (usual.unit == "share" && !(fault.magnitude >= 0.0 && fault.magnitude <= 1.0))
    throw std::invalid_argument(name + ": its size is a share of the frames; give 0 to 1");
  if (usual.unit == "sigma" && !(fault.magnitude >= 0.0))
    throw std::invalid_argument(name + ": its size is a number of sigmas; give 0 or more");
  const bool may_lead = fault.kind.act == Act::shifted;
  if (usual.unit == "s" && !may_lead && !(fault.magnitude >= 0.0))
    throw std::invalid_argument(name + ": its size is a time; give 0 s or more");
}

Fault parse_fault(std::string_view text) {
  const std::vector<std::string_view> parts = split(text);
  if (parts.size() > 4)
    throw std::invalid_argument(tools::quoted(text) +
                                ": has more parts than KIND:BEGIN:LENGTH:SIZE");
  Fault fault = fault_of(parse_kind(parts[0]));
  if (parts.size() > 1) read(text, parts[1], "begin", fault.begin_s);
  if (parts.size() > 2) read(text, parts[2], "length", fault.duration_s);
  if (parts.size() > 3) read(text, parts[3], "size", fault.magnitude);
  check(fault);
  return fault;
}

}  // namespace odomd::fault
