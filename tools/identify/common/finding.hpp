// The results of an identification: values with their standard uncertainty, each for one key of the
// configuration or for information only. Every method prints them as a table or JSON on standard
// output, with warnings on standard error, and writes them to a configuration if requested. The
// methods themselves (add_mass(), ...) are declared at the end.
#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/command.hpp"
#include "tools/identify/common/measured.hpp"

namespace odomd::tools {

/// Whether the experiment determined the value at all.
enum class Determined : std::uint8_t { yes, no };

/// Whether a determined value is written to a configuration.
enum class Use : std::uint8_t { write, leave };

/// Whether the uncertainty is meaningful as a share of the value. It is not for a bias, an offset,
/// a position or a latency: for these zero is a normal value.
enum class Share : std::uint8_t { meaningful, meaningless };

struct Finding {
  std::string name;    ///< in words: "cornering stiffness, front"
  std::string key;     ///< its key: "vehicle.mass", "camera.lever_arm[0]"; empty: none
  double value = 0.0;  ///< SI
  double sigma = 0.0;  ///< standard uncertainty (one sigma), in the value's unit
  std::string unit;    ///< "kg", "N/rad", "s"; empty: a pure number
  Determined determined = Determined::yes;  ///< no: shown with the reason, never written
  std::string remark;    ///< limits of the value, or why it is undetermined; may be empty
  Use use = Use::write;  ///< leave: shown with the reason, not written
  Share share = Share::meaningful;  ///< as_text() also decides by the key

  /// The experiment does not determine the value, for this reason.
  void reject(std::string why) {
    determined = Determined::no;
    remark = std::move(why);
  }
};

/// The results of one run of a method.
struct Findings {
  std::string method;  ///< "mass", "stiffness": the subcommand
  std::string origin;  ///< for the note after each written number: "scale, 4 wheels"
  std::vector<Finding> values;
  diagnostics::Diagnostics warnings;
  std::string table;               ///< data of the method, printed above the values; may be empty
  nlohmann::ordered_json details;  ///< further figures of the method for --json; may be null

  /// Adds a value that the experiment determined.
  Finding& add(std::string name, std::string key, const Measured& measured, std::string unit,
               std::string remark = "") {
    values.push_back({.name = std::move(name),
                      .key = std::move(key),
                      .value = measured.value,
                      .sigma = measured.sigma,
                      .unit = std::move(unit),
                      .remark = std::move(remark)});
    return values.back();
  }
};

/// Adds a warning; `seen` is a format string for the values.
template <typename... Values>
void add_warning(diagnostics::Diagnostics& warnings, const diagnostics::Kind& kind,
                 std::string subject, fmt::format_string<Values...> seen, Values&&... values) {
  warnings.push_back(
      found(kind, std::move(subject), fmt::format(seen, std::forward<Values>(values)...)));
}

inline void to_json(nlohmann::ordered_json& json, const Measured& measured) {
  json = {{"value", measured.value}, {"sigma", measured.sigma}};
}

/// Raises a negative latency to 0, the minimum of the configuration, with a remark.
void raise_to_zero(Finding& latency);

struct Delivery {
  bool json = false;
  std::string write;   ///< the configuration to patch; empty: none
  bool force = false;  ///< also replace values that are more precise
};

/// Adds --json, --write and --force to a method.
void add_delivery(Command method, Delivery& delivery);

/// Throws if the configuration to patch is missing or not writable; call it before the work.
void check(const Delivery& delivery);

/// A number in a configuration, with the uncertainty that an earlier method noted next to it; sigma
/// 0: no note. Nothing if the key is missing.
[[nodiscard]] std::optional<Measured> measured_in(const std::string& file, const std::string& key);

/// Prints, then patches the configuration and lists the keys on standard error. A configured value
/// whose note states a smaller uncertainty is kept, with a warning, unless forced. Throws if the
/// configuration cannot be patched; it is then unchanged.
void deliver(Findings findings, const Delivery& delivery);

/// Adds the options, and as the method's action delivers the findings that `identify` returns.
/// `options` is a shared pointer to a struct with a `delivery`.
template <class Options, class Identify>
void add_delivery(Command method, const Options& options, Identify identify) {
  add_delivery(method, options->delivery);
  method.callback([options, identify] {
    check(options->delivery);
    deliver(identify(*options), options->delivery);
  });
}

/// The table: name, value ± 2 sigma, unit, per cent, key, remark.
[[nodiscard]] std::string as_text(const Findings& findings);
[[nodiscard]] nlohmann::ordered_json as_json(const Findings& findings);

// The methods: each file adds its own subcommand. In the order of use: on the scale, on the cords,
// at rest, on circles, on a lap.
void add_mass(Command identify);
void add_cog(Command identify);
void add_inertia(Command identify);
void add_noise(Command identify);
void add_track(Command identify);
void add_stiffness(Command identify);
void add_latency(Command identify);
void add_fit(Command identify);

}  // namespace odomd::tools
