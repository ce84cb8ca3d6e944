// Values of the daemon's status document in words, and rates between two documents. A missing value
// is "-". All throw a nlohmann::json::exception where a member is of another type than it must be.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::tools {

using Json = nlohmann::json;

inline constexpr double degrees = 180.0 / std::numbers::pi;  ///< in a radian
inline constexpr double full_turn = 2.0 * std::numbers::pi;  ///< [rad]

/// A member of an object, or null.
[[nodiscard]] const Json& member(const Json& object, const std::string& key);

/// The element of the same `name` in an array of an earlier document, or null.
[[nodiscard]] const Json& namesake(const Json& array, const Json& name);

[[nodiscard]] std::string number(const Json& value, int decimals, double factor = 1.0);
/// Three significant digits: "0.00321", "0.300", "-" for null.
[[nodiscard]] std::string significant(const Json& value);
[[nodiscard]] std::string count(const Json& value);
/// "1 reset", "2 resets", "- resets".
[[nodiscard]] std::string counted(const Json& value, std::string_view noun);
[[nodiscard]] std::string word(const Json& value);
[[nodiscard]] bool is_true(const Json& value);

/// Seconds as precise as it matters: "12.3 ms", "4.5 s", "2 h 03 min"; "never" for null.
[[nodiscard]] std::string duration(const Json& value);

/// Of a source of the status: "fine", or what is wrong with it: "overdue", "frozen", ...
[[nodiscard]] std::string source_state(const Json& source);

[[nodiscard]] std::string hexadecimal(const Json& value);

/// Of an object of counts, all together.
[[nodiscard]] std::uint64_t sum(const Json& counts);

/// Whether any of the sources reports innovations; else the model tests none.
[[nodiscard]] bool is_tested(const Json& sources);

/// Of a source's `innovations`: the mean of νᵀS⁻¹ν over what it should be, "1.02"; and how many
/// lie inside χ²₉₅, "95.1".
[[nodiscard]] std::string nis_by_expectation(const Json& innovations);
[[nodiscard]] std::string percent_inside(const Json& innovations);

/// A calibration of a sensor or the car, in usual units.
struct Calibration {
  std::string name;
  std::string value;
  std::string sigma;
  std::string unit;  ///< with a blank before it; of a scale empty
  bool valid = false;
};
/// Of the status document. Those that the model does not estimate are left out.
[[nodiscard]] std::vector<Calibration> calibrations_of(const Json& now);

/// Rates over the time between two documents of one daemon, else since its start.
class Rates {
 public:
  Rates(const Json& now, const std::optional<Json>& before);

  /// The earlier document; an empty object where there is none that counts.
  [[nodiscard]] const Json& before() const { return before_; }
  /// Per second, "-" where there is none. Of counts in the documents null then counts as 0.
  [[nodiscard]] std::string of(std::uint64_t now, std::uint64_t then) const;
  [[nodiscard]] std::string of(const Json& now, const Json& then) const;

 private:
  Json before_ = Json::object();
  double seconds_ = 0.0;
};

}  // namespace odomd::tools
