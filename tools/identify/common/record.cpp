#include "tools/identify/common/record.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/refuse.hpp"

namespace odomd::tools {
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
