#include "tools/identify/common/inputs.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

struct UnitName {
  std::string_view name;
  double per_si;  // units per SI unit: 175 / 1000 is 0.175, 175 * 1e-3 is not
};

struct Units {
  std::string_view in_words;
  std::array<UnitName, 3> names;  // the SI unit first
};

// In the order of Dimension.
constexpr std::array<Units, 5> units{{
    {"kg or g", {{{"kg", 1.0}, {"g", 1e3}}}},
    {"m, cm or mm", {{{"m", 1.0}, {"cm", 1e2}, {"mm", 1e3}}}},
    {"rad or deg", {{{"rad", 1.0}, {"deg", 180.0 / std::numbers::pi}}}},
    {"s or ms", {{{"s", 1.0}, {"ms", 1e3}}}},
    {"no unit, or %", {{{"", 1.0}, {"%", 1e2}}}},
}};

const Units& of(Dimension dimension) {
  return units[static_cast<std::size_t>(dimension)];
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

double parse_quantity(std::string_view text, Dimension dimension, std::string_view option) {
  const std::string_view whole = trimmed(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (error != std::errc{} || !std::isfinite(value))
    refuse("{}: {} is not a number", option, quoted(text));
  const std::string_view unit = trimmed(whole.substr(static_cast<std::size_t>(end - whole.data())));
  if (unit.empty()) return value;
  for (const UnitName& name : of(dimension).names)
    if (name.name == unit) return value / name.per_si;
  if (unit.front() == ',')
    refuse("{}: {}: write a decimal point, not a comma", option, quoted(text));
  refuse("{}: {}: the unit must be {}", option, quoted(text), of(dimension).in_words);
}

double parse_positive(std::string_view text, Dimension dimension, std::string_view option) {
  const double value = parse_quantity(text, dimension, option);
  if (value > 0.0) return value;
  refuse("{}: {} is not possible; it must be greater than 0", option, quoted(text));
}

double parse_not_negative(std::string_view text, Dimension dimension, std::string_view option) {
  const double value = parse_quantity(text, dimension, option);
  if (value >= 0.0) return value;
  refuse("{}: {} is not possible; it must be 0 or greater", option, quoted(text));
}

double parse_or(double otherwise, std::string_view text, Dimension dimension,
                std::string_view option) {
  return text.empty() ? otherwise : parse_not_negative(text, dimension, option);
}

double parse_plausible(std::string_view text, Dimension dimension, std::string_view option,
                       Plausible range) {
  const double value = parse_positive(text, dimension, option);
  if (value >= range.from && value <= range.to) return value;
  const std::string_view unit = of(dimension).names.front().name;
  refuse(
      "{}: {} is {:.4g} {}, but {:g} to {:g} {} is plausible; a number without a unit "
      "is in {}; units are {}",
      option, quoted(text), value, unit, range.from, range.to, unit, unit, of(dimension).in_words);
}

void add_measured_option(Command method) {
  method.add_measurements(
      "--measured", "JSON",
      "Measurements written down in a file: {\"total\": [2.985, 2.986], "
      "\"spacing\": \"200mm\"}; names are those of the options, with underscores");
}

namespace {

std::int64_t limit(const std::string& text, const std::string& option, std::int64_t otherwise) {
  if (text.empty()) return otherwise;
  const auto time = parse_seconds(text);
  if (!time) refuse("{}: {} is not a time in seconds", option, tools::quoted(text));
  return *time;
}

SignalLog read_csv(const std::string& file, const std::vector<estimator::Source>& columns) {
  std::vector<std::string> names{"t"};
  for (const estimator::Source source : columns) names.push_back(name_of(source));
  const std::size_t required = columns.size() == 1 ? 2 : 1;
  const std::span optional = std::span(names).subspan(1);
  std::ifstream input = open_input(file);
  if (columns.size() > 1 && input.peek() == std::ifstream::traits_type::eof())
    refuse(
        "{}: is empty; a first line \"t,{}\" is expected, with t [s] and at least one "
        "of the others",
        file, fmt::join(optional, ","));
  CsvReader rows(input, file, names, LastLine::keep_whole, {.required = required});
  SignalLog log;
  std::optional<std::int64_t> before;
  while (rows.next()) {
    const std::int64_t time = rows.time_ns(0);
    if (before && time <= *before)
      rows.fail(0, time == *before ? "repeats the time of the row before; each sample needs its own"
                                   : "earlier than the row before; sort the rows by time");
    before = time;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (rows.has(1 + i)) log.of(columns[i]).add(time, rows.number(1 + i));
    }
  }
  log.name = file;
  log.why_empty.fill("fill its column");
  append(log.warnings, diagnostics::kind("file_content"), rows.warnings());
  if (!before) refuse("{}: has no row below its header", file);
  if (std::ranges::all_of(log.signals, &Series::empty)) {
    refuse("{}: has none of the columns {}", file, fmt::join(optional, ", "));
  }
  return log;
}

/// Cuts all signals to the same part, counted from the first sample of any signal.
void cut(SignalLog& log, const RecordOptions& options) {
  if (options.from.empty() && options.to.empty()) return;
  std::int64_t begin = std::numeric_limits<std::int64_t>::max(), end = 0;
  for (const Series& series : log.signals) {
    if (series.empty()) continue;
    begin = std::min(begin, series.t_ns.front());
    end = std::max(end, series.t_ns.back());
  }
  const std::int64_t from = limit(options.from, "--from", 0);
  const std::int64_t to = limit(options.to, "--to", std::numeric_limits<std::int64_t>::max());
  for (std::size_t k = 0; k < log.signals.size(); ++k) {
    Series& series = log.signals[k];
    Series kept;
    for (std::size_t i = 0; i < series.size(); ++i) {
      const std::int64_t since = series.t_ns[i] - begin;
      if (since < from || since > to) continue;
      kept.add(series.t_ns[i], series.value[i]);
    }
    if (kept.empty() && !series.empty()) log.why_empty[k] = "none lies between --from and --to";
    series = kept;
  }
  if (std::ranges::all_of(log.signals, &Series::empty))
    refuse("--from, --to: no part of the record lies between them; it is {:.1f} s long",
           1e-9 * static_cast<double>(end - begin));
}

}  // namespace

void add_record_options(Command method, RecordOptions& options) {
  method.add("--config", "TOML", options.config,
             "Configuration of the car (TOML), for the signals of --can");
  method.add("--can", "SRC", options.logs, "Log of candump -L, or - for standard input; repeatable",
             {one_each()});
  method.add("--csv", "CSV", options.csv,
             "Record instead of a log: columns t [s], yaw_rate [rad/s]");
  method.add("--from", "T", options.from, "Start time [s] after the record's first sample");
  method.add("--to", "T", options.to, "End time [s] after the record's first sample");
}

SignalLog read_record(const RecordOptions& options, const std::vector<estimator::Source>& columns) {
  if (!options.csv.empty() && !options.logs.empty()) refuse("--csv and --can: give one of them");
  if (!options.logs.empty() && options.config.empty())
    refuse("--can needs --config, which names the signals in the log");
  SignalLog log = options.csv.empty() ? read_signals(daemon::load_config(options.config),
                                                     options.logs, options.damage)
                                      : read_csv(options.csv, columns);
  cut(log, options);
  return log;
}

}  // namespace odomd::tools
