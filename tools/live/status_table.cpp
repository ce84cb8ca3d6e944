#include "tools/live/status_table.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

// A count of zero is "0" in the whole form, and blank on a screen.
Span problems(std::string counts, Form form) {
  return {counts.empty() && form == Form::whole ? "0" : std::move(counts), Style::warning};
}

bool is_unused(const StatusValue& source) {
  return source["verdicts/source_off"].count() > 0 && source["verdicts/fused"].count() == 0;
}

Span fused(const StatusValue& source) {
  return {source["verdicts/fused"].text(), is_unused(source) ? Style::dim : Style::plain};
}

Span last_verdict(const StatusValue& source, Form form) {
  if (form != Form::whole && is_unused(source)) return {"unused by the model", Style::dim};
  const std::string last = source["last_verdict"].text();
  const std::string ratio = source["test_ratio"].number(2);
  const bool fine = last == "fused" || last == "source_off" || last == "none";
  return {ratio == "-"          ? last
          : form == Form::whole ? fmt::format("{} (test ratio {})", last, ratio)
                                : fmt::format("{} {}", last, ratio),
          fine ? Style::plain : Style::warning};
}

Span innovation(const StatusValue& source) {
  std::string text;
  for (const StatusValue& component : source["innovation"].elements())
    text += (text.empty() ? "" : " ") + component.number(4);
  return {text.empty() ? "-" : text};
}

struct Unit {
  std::string_view calibration;
  std::string_view name;
  double factor;
};

// A scale has no unit.
Unit unit_of(const StatusValue& calibration) {
  constexpr std::array with_unit{
      Unit{"gyro_bias", " deg/s", degrees}, Unit{"accel_bias_x", " m/s2", 1.0},
      Unit{"accel_bias_y", " m/s2", 1.0},   Unit{"steering_offset", " deg", degrees},
      Unit{"gyro_latency", " ms", 1e3},     Unit{"wheel_latency", " ms", 1e3},
      Unit{"steering_latency", " ms", 1e3}, Unit{"grip", " m/s2", 1.0}};
  const auto* const found =
      std::ranges::find(with_unit, calibration["name"].text(), &Unit::calibration);
  return found == with_unit.end() ? Unit{"", "", 1.0} : *found;
}

}  // namespace

Column column(std::string title, std::string path, std::string (StatusValue::*in_words)() const) {
  return {std::move(title), [path = std::move(path), in_words](const StatusValue& row) {
            return Span{(row[path].*in_words)()};
          }};
}

Column left(Column column) {
  column.flush_left = true;
  return column;
}

Lines table_of(const std::vector<Column>& columns, const std::vector<StatusValue>& rows) {
  if (rows.empty()) return {};
  Table table{.flush_left = {}};
  Lines lines(1);
  for (const Column& column : columns) {
    if (column.flush_left) table.flush_left.push_back(table.header.size());
    table.header.push_back(column.title);
    lines[0].push_back({"", Style::dim});
  }
  for (const StatusValue& row : rows) {
    lines.emplace_back();
    table.rows.emplace_back();
    for (const Column& column : columns) {
      lines.back().push_back(column.cell(row));
      table.rows.back().push_back(lines.back().back().text);
    }
  }
  const auto aligned = table.aligned();
  for (std::size_t row = 0; row < lines.size(); ++row)
    for (std::size_t i = 0; i < columns.size(); ++i)
      lines[row][i].text = (i == 0 ? "" : "  ") + aligned[row][i];
  if (as_text(lines[0]).empty()) lines.erase(lines.begin());
  return lines;
}

Lines source_table(const StatusValue& status, Form form) {
  std::vector<StatusValue> sources = status["sources"].elements();
  std::erase_if(sources, [](const StatusValue& source) { return !source["configured"].is_true(); });
  const bool tested =
      form != Form::screen && std::ranges::any_of(sources, [](const StatusValue& source) {
        return source["innovations/mean_nis"].exists();
      });
  const bool whole = form == Form::whole;
  const auto state = [](const StatusValue& source) {
    return Span{source_state(source), source["healthy"].is_true() ? Style::good : Style::bad};
  };
  const auto last = [form](const StatusValue& source) { return last_verdict(source, form); };
  const auto not_fused = [form](const StatusValue& source) {
    const StatusValue verdicts = source["verdicts"];
    return problems(form == Form::whole ? verdicts.nonzero({"fused"})
                                        : verdicts.nonzero({"fused", "source_off"}),
                    form);
  };
  std::vector<Column> columns{left(column("source", "name")), {"state", state, true}};
  columns.push_back(column("age", "age_s", &StatusValue::duration));
  columns.insert(columns.end() - (whole ? 0 : 1), column("1/s", "verdicts", &StatusValue::rate));
  columns.push_back({"fused", fused});
  columns.push_back({"last", last, true});
  if (tested) {
    if (whole) columns.push_back({"innovation", innovation});
    columns.push_back({"NIS", [](const auto& source) { return Span{nis_by_expectation(source)}; }});
    columns.push_back({"in 95 %", [](const auto& source) {
                         return Span{source["innovations/inside_95"].number(1, 100.0)};
                       }});
  }
  columns.insert(whole ? columns.begin() + 5 : columns.end(), {"not fused", not_fused, true});
  return table_of(columns, sources);
}

Lines message_table(const StatusValue& status, Form form) {
  const bool whole = form == Form::whole;
  const auto refused = [form](const StatusValue& message) {
    const StatusValue verdicts = message["verdicts"];
    std::string text = verdicts.nonzero({"decoded", "unmapped", "no_sample"});
    if (const auto lost = message["some_lost"].count(); form != Form::whole && lost > 0)
      text += fmt::format("{}{} after a gap", text.empty() ? "" : ", ", lost);
    return problems(text, form);
  };
  std::vector<Column> columns{left(column("message", "name")),
                              left(column("id", "id", &StatusValue::hexadecimal))};
  if (!whole) columns.push_back(column("1/s", "verdicts", &StatusValue::rate));
  columns.push_back(column("age", "age_s", &StatusValue::duration));
  columns.push_back(column("decoded", "verdicts/decoded"));
  columns.push_back({whole ? "failed" : "refused", refused, true});
  return table_of(columns, status["messages"].elements());
}

Lines calibration_table(const StatusValue& status, Form form, Glyphs glyphs) {
  std::vector<StatusValue> calibrations = status["calibrations"].elements();
  std::erase_if(calibrations, [](const StatusValue& one) { return !one["sigma"].exists(); });
  const bool whole = form == Form::whole;
  const auto value = [](const StatusValue& calibration) {
    return Span{calibration["value"].number(4, unit_of(calibration).factor), Style::strong};
  };
  const auto sigma = [glyphs](const StatusValue& calibration) {
    const Unit unit = unit_of(calibration);
    return Span{fmt::format("{} {}{}", glyphs == Glyphs::unicode ? "±" : "+-",
                            calibration["sigma"].number(4, unit.factor), unit.name)};
  };
  const auto learnt = [whole](const StatusValue& calibration) {
    const bool valid = calibration["valid"].is_true();
    return Span{!valid ? "not yet" : whole ? "yes" : "learnt", valid ? Style::good : Style::dim};
  };
  return table_of({left(column(whole ? "calibration" : "", "name")),
                   {whole ? "value" : "", value},
                   {"", sigma, true},
                   {whole ? "learnt" : "", learnt, true}},
                  calibrations);
}

}  // namespace odomd::tools
