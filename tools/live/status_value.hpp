// The daemon's status document: values in words, with rates between two documents; sections of text
// for people; and metrics for programs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/live/line.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {

using Json = nlohmann::json;

/// A value of a status document, or nothing if the daemon does not report it; and the same value of
/// an earlier document. Refers to the documents. Nothing is "-" in words. All functions throw a
/// nlohmann::json::exception if the value has the wrong type.
class StatusValue {
 public:
  StatusValue();  ///< nothing
  /// Rates are those between the documents; without an earlier document of the same daemon, those
  /// since the daemon's start.
  explicit StatusValue(const Json& now, const std::optional<Json>& before = std::nullopt);

  /// A member of an object: "pose", or "pose/x".
  [[nodiscard]] StatusValue operator[](std::string_view path) const;
  /// The elements of an array, each with the earlier element of the same `name`.
  [[nodiscard]] std::vector<StatusValue> elements() const;
  [[nodiscard]] StatusValue named(std::string_view name) const;

  [[nodiscard]] const Json& json() const { return *now_; }
  [[nodiscard]] bool exists() const { return !now_->is_null(); }
  [[nodiscard]] bool is_true() const { return exists() && now_->get<bool>(); }
  /// The number; `otherwise` for nothing.
  [[nodiscard]] double value(double otherwise = 0.0) const;
  /// A count, or the sum of an object's counts; 0 for nothing.
  [[nodiscard]] std::uint64_t count() const;

  /// A word or a count.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::string number(int decimals, double factor = 1.0) const;
  /// Three significant digits: "0.00321", "0.300".
  [[nodiscard]] std::string significant() const;
  /// "1 reset", "2 resets", "- resets".
  [[nodiscard]] std::string counted(std::string_view noun) const;
  /// Seconds with a suitable unit: "12.3 ms", "4.5 s", "2 h 03 min"; nothing is "never".
  [[nodiscard]] std::string duration() const;
  [[nodiscard]] std::string hexadecimal() const;
  /// The change of count() per second.
  [[nodiscard]] std::string rate() const;
  /// The counts of an object that are not 0: "3 gated, 1 too_old".
  [[nodiscard]] std::string nonzero(std::initializer_list<std::string_view> without) const;

 private:
  StatusValue(const Json& now, const Json& before, double seconds)
      : now_(&now), before_(&before), seconds_(seconds) {}

  const Json* now_;
  const Json* before_;
  double seconds_ = 0.0;
};

/// Like StatusValue::duration().
[[nodiscard]] std::string duration_in_words(double seconds);

/// The state of a source: "fine", or its problem: "overdue", "frozen", ...
[[nodiscard]] std::string source_state(const StatusValue& source);

/// From a source's `innovations`: the mean of νᵀS⁻¹ν / its expectation, "1.02".
[[nodiscard]] std::string nis_by_expectation(const StatusValue& source);

/// "── pose ── note ──────", as wide as the page.
[[nodiscard]] Line title(std::string_view name, std::string_view note, std::size_t columns);

/// Sources, beat, calibrations, camera, buses, messages and noise, each with its title; those
/// without content are absent. Missing members are shown as "-". Throws a
/// nlohmann::json::exception if a member has the wrong type.
[[nodiscard]] Lines status_sections(const StatusValue& status, std::size_t columns);

/// OpenMetrics, restricted to the types of Prometheus' older text format, so that node_exporter can
/// collect the text from a file. Empty status: nobody answers. Throws like status_sections().
[[nodiscard]] std::string open_metrics(const std::optional<Json>& status);

}  // namespace odomd::tools
