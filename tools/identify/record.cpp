#include "tools/identify/record.hpp"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>

#include "tools/csv.hpp"
#include "tools/files.hpp"

namespace odomd::tools {
namespace {

std::int64_t limit(const std::string& text, const std::string& option, std::int64_t otherwise) {
  if (text.empty()) return otherwise;
  const auto time = parse_seconds(text);
  if (!time)
    throw std::invalid_argument(option + ": " + tools::quoted(text) + " is not a time in seconds");
  return *time;
}

}  // namespace

void add_record_options(CLI::App& method, RecordOptions& options, const std::string& group) {
  method.add_option("--config", options.config, "Configuration that tells the signals of --can")
      ->type_name("TOML")
      ->group(group);
  method
      .add_option("--can", options.logs, "Log of candump -L, or - for standard input; repeatable")
      ->type_name("SRC")
      ->allow_extra_args(false)
      ->group(group);
  method.add_option("--csv", options.csv, "Instead of a log: columns t [s] and yaw_rate [rad/s]")
      ->type_name("CSV")
      ->group(group);
  method
      .add_option("--from", options.from, "Leave out what is before, from the record's begin [s]")
      ->type_name("T")
      ->group(group);
  method.add_option("--to", options.to, "Leave out what is after, from the record's begin [s]")
      ->type_name("T")
      ->group(group);
}

bool is_given(const RecordOptions& options) {
  return !options.csv.empty() || !options.logs.empty();
}

std::string name_of(const RecordOptions& options) {
  return options.csv.empty() ? options.logs.front() : options.csv;
}

Series read_csv_series(const std::string& file, const std::string& column,
                       std::vector<std::string>& warnings) {
  std::ifstream input = open_input(file);
  CsvReader rows(input, file, {"t", column});
  Series series;
  while (rows.next()) {
    const std::int64_t time = rows.time_ns(0);
    if (!series.empty() && time <= series.t_ns.back())
      rows.fail(0, time == series.t_ns.back()
                       ? "the time of the row before again; each sample needs its own"
                       : "earlier than the row before; sort the rows by time");
    series.t_ns.push_back(time);
    series.value.push_back(rows.number(1));
  }
  for (const std::string& warning : rows.warnings()) warnings.push_back(warning);
  if (series.empty()) throw std::invalid_argument(file + ": holds no row below its header");
  return series;
}

Series read_yaw_rate(const RecordOptions& options, std::vector<std::string>& warnings) {
  if (!options.csv.empty() && !options.logs.empty())
    throw std::invalid_argument("--csv and --can: give one of them");
  if (!options.logs.empty() && options.config.empty())
    throw std::invalid_argument("--can needs --config, which tells the signals in the log");
  Series series;
  if (!options.csv.empty()) {
    series = read_csv_series(options.csv, "yaw_rate", warnings);
  } else {
    SignalLog log = read_signals(daemon::load_config(options.config), options.logs);
    for (const std::string& warning : log.warnings) warnings.push_back(warning);
    series = log.of(estimator::Source::yaw_rate);
    if (series.empty())
      throw std::invalid_argument(
          fmt::format("{}: no yaw_rate in it by {}; map yaw_rate in [can.signals], or log the IMU",
                      options.logs.front(), options.config));
  }
  const std::int64_t begin = series.t_ns.front();
  const std::int64_t longest = std::numeric_limits<std::int64_t>::max() - begin;
  const std::int64_t from = limit(options.from, "--from", 0);
  const std::int64_t to = limit(options.to, "--to", longest);
  Series cut;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const std::int64_t since = series.t_ns[i] - begin;
    if (since < from || since > to) continue;
    cut.t_ns.push_back(series.t_ns[i]);
    cut.value.push_back(series.value[i]);
  }
  if (cut.empty())
    throw std::invalid_argument(
        fmt::format("--from, --to: nothing of the record is in between; it is {:.1f} s long",
                    1e-9 * static_cast<double>(series.t_ns.back() - begin)));
  return cut;
}

}  // namespace odomd::tools
