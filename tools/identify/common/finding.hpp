// The results of an identification: values with their standard uncertainty, each for one key of the
// configuration or for information only.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/measured.hpp"

namespace odomd::tools {

/// Whether the experiment determined the value at all.
enum class Determined : std::uint8_t { yes, no };

/// Whether a determined value is written to a configuration.
enum class Use : std::uint8_t { write, leave };

/// Whether the uncertainty as a share of the value is meaningful. For a bias, an offset, a position
/// or a latency it is not: zero is a value like any other.
enum class Share : std::uint8_t { meaningful, meaningless };

struct Finding {
  std::string name;    ///< in words: "cornering stiffness, front"
  std::string key;     ///< where it belongs: "vehicle.mass", "camera.lever_arm[0]"; empty: nowhere
  double value = 0.0;  ///< SI
  double sigma = 0.0;  ///< standard uncertainty (one sigma), in the value's unit
  std::string unit;    ///< "kg", "N/rad", "s"; empty: a pure number
  Determined determined = Determined::yes;  ///< no: shown with the reason, never written
  std::string remark;               ///< what limits it, or why it is not determined; may be empty
  Use use = Use::write;             ///< leave: shown with the reason, not written
  Share share = Share::meaningful;  ///< as_text() also decides by the key
};

/// The results of one run of a method.
struct Findings {
  std::string method;  ///< "mass", "stiffness": the subcommand
  std::string origin;  ///< for the note after each written number: "scale, 4 wheels"
  std::vector<Finding> values;
  diagnostics::Diagnostics warnings;
  nlohmann::ordered_json details;  ///< further figures of the method for --json; may be null
};

/// A value that the experiment determined.
[[nodiscard]] inline Finding as_finding(std::string name, std::string key, const Measured& measured,
                                        std::string unit, std::string remark = "") {
  return {.name = std::move(name),
          .key = std::move(key),
          .value = measured.value,
          .sigma = measured.sigma,
          .unit = std::move(unit),
          .remark = std::move(remark)};
}

/// The same with the reason why it did not.
[[nodiscard]] inline Finding undetermined(Finding finding, std::string why) {
  finding.determined = Determined::no;
  finding.remark = std::move(why);
  return finding;
}

}  // namespace odomd::tools
