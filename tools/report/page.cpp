#include "tools/report/page.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <ranges>
#include <string_view>
#include <vector>

#include "tools/chart/picture.hpp"
#include "tools/cli/text.hpp"
#include "tools/evaluation/evaluated_drive.hpp"
#include "tools/report/figures.hpp"

namespace odomd::tools::report {
namespace {

using svg::escaped;

// Two pictures (or three small ones) side by side if there is room, one on a phone. On a phone each
// table row becomes a card with its cells below each other, so that nothing scrolls sideways.
constexpr const char* style = R"css(
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.2rem 1rem 3rem; max-width: 80rem; background: #f6f7f9; color: #1f2933;
  font: 16px/1.5 "DejaVu Sans", Verdana, system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .4rem 0 .6rem; overflow-wrap: anywhere; }
h2 { font-size: 1.3rem; margin: 2.4rem 0 .4rem; padding-top: .8rem; border-top: 2px solid #cbd2d9; overflow-wrap: anywhere; }
h3 { font-size: 1.05rem; margin: 1.6rem 0 .5rem; }
p { margin: .4rem 0 .8rem; max-width: 52rem; }
.faint, figcaption { color: #5f6b7a; font-size: .88rem; }
.scroll { overflow-x: auto; margin: .6rem 0 1rem; }
table { border-collapse: collapse; background: #fff; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .7rem; text-align: right; border-bottom: 1px solid #e6e9ed; vertical-align: bottom; }
th { font-weight: 600; border-bottom: 2px solid #cbd2d9; }
td.words, th.words { text-align: left; }
td.words { min-width: 5.5rem; }
td small { display: block; max-width: 26rem; color: #5f6b7a; font-weight: 400; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem .8rem; margin: -.4rem 0 1rem; max-width: 60rem; color: #5f6b7a; font-size: .85rem; }
dt { font-weight: 600; } dd { margin: 0; }
.verdict { background: #fff; border-left: 8px solid; border-radius: 4px; padding: .5rem 1rem; margin: .6rem 0 1.2rem; }
.verdict p { margin: .2rem 0; } .verdict ul { margin: .4rem 0; padding-left: 1.2rem; }
.verdict b { text-transform: capitalize; }
.good { border-color: #009e73; } .look-at { border-color: #e69f00; } .wrong { border-color: #d55e00; }
tr.first td { border-top: 2px solid #e6e9ed; }
.figures { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 26rem), 1fr)); align-items: start; }
.figures.small { grid-template-columns: repeat(auto-fill, minmax(min(100%, 22rem), 1fr)); }
figure { margin: 0; padding: .5rem; background: #fff; border: 1px solid #e0e4e9; border-radius: 8px; break-inside: avoid; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { padding: .1rem .5rem .4rem; }
.warning { border-left: 4px solid #d55e00; padding: .2rem .8rem; background: #fff; max-width: none; }
details { margin: .8rem 0; }
summary { cursor: pointer; }
pre, code { font: .82rem/1.45 "DejaVu Sans Mono", Consolas, monospace; }
code { overflow-wrap: anywhere; }
pre { background: #fff; border: 1px solid #e0e4e9; border-radius: 8px; padding: .7rem; overflow-x: auto; }
@media (max-width: 40rem) {
  body { padding: .6rem .5rem 2rem; font-size: 15px; }
  figure { padding: .2rem; }
  pre { white-space: pre-wrap; overflow-wrap: anywhere; }
  dl { display: block; margin-top: 0; }
  dd { margin-bottom: .3rem; }
  .scroll { overflow: visible; }
  table, tbody, td { display: block; }
  thead { display: none; }
  tr { display: grid; grid-template-columns: repeat(auto-fill, minmax(5.2rem, 1fr)); border: 1px solid #e0e4e9; border-radius: 6px; margin-bottom: .5rem; }
  td, tr.first td { border: none; padding: .25rem .5rem; text-align: left; overflow-wrap: anywhere; min-width: 0; }
  td:first-child { grid-column: 1 / -1; font-weight: 600; }
  td[data-name]::before { content: attr(data-name); display: block; color: #5f6b7a; font-size: .75rem; }
}
@media print {
  @page { margin: 14mm; }
  body { background: #fff; max-width: none; padding: 0; font-size: 9.5pt; }
  h2 { border-top: none; }
  section + section { break-before: page; }
  h2, h3 { break-after: avoid; }
  .figures { grid-template-columns: 1fr 1fr; gap: 4mm; }
  .figures.small { grid-template-columns: 1fr 1fr 1fr; }
  th, td { padding: .15rem .5rem; }
  .scroll, pre { overflow: visible; }
  .short { break-inside: avoid; }
  tr { break-inside: avoid; }
  pre { white-space: pre-wrap; }
  figure { border: none; padding: 0; }
}
)css";

// Allows a line break after each underscore, as in "kinematic_printed".
std::string breakable(const std::string& name) {
  std::string words;
  for (const char letter : name) {
    words += letter;
    if (letter == '_') words += "<wbr/>";
  }
  return words;
}

/// Words in tables other than metrics.
constexpr std::array<std::pair<std::string_view, std::string_view>, 9> other_words{{
    {"fused", "samples that the filter used"},
    {"gated", "samples left out because they were too far from what it expected"},
    {"late", "samples older than its window"},
    {"other", "samples not used for other reasons"},
    {"tested", "samples compared with what the filter expected"},
    {"NIS / expected",
     "mean squared innovation over what the filter expects. 1: the noise is right; above: set too "
     "small; below: too large"},
    {"inside 95 % [%]", "share of samples within the filter's own 95 % limit; 95 is right"},
    {"value", "learnt by the filter, at the end"},
    {"3σ", "three standard deviations of it"},
}};

std::string explanation_of(std::string_view label) {
  const auto* const other =
      std::ranges::find(other_words, label, &decltype(other_words)::value_type::first);
  return escaped(std::string{other != other_words.end() ? other->second : definition_of(label)});
}

// The definitions of the table's columns.
std::string definitions_of(const Table& table) {
  std::string list;
  for (const std::string& label : table.header)
    if (const std::string text = explanation_of(label); !text.empty())
      list += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escaped(label), text);
  return list.empty() ? "" : "<dl>\n" + list + "</dl>\n";
}

std::string html_of(const Table& table) {
  constexpr std::size_t rows_of_a_short_one = 24;
  const auto is_words = [&table](std::size_t column) {
    return std::ranges::find(table.flush_left, column) != table.flush_left.end();
  };
  const auto row_of = [&](const std::vector<std::string>& cells, const char* tag,
                          const char* row_class) {
    std::string row = fmt::format("<tr{}>", row_class);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      std::string words = escaped(cells[i]);
      if (std::string_view{tag} == "th") words = breakable(words);
      if (words.starts_with('-') && words.size() > 1) words.replace(0, 1, "\u2212");
      std::string name;
      if (std::string_view{tag} == "td" && i > 0 && !table.header[i].empty())
        name = fmt::format(" data-name=\"{}\"", escaped(table.header[i]));
      else if (const std::string text = explanation_of(cells[i]);
               i == 0 && table.header[0].empty() && !text.empty())
        words += "<small>" + text + "</small>";
      row += fmt::format("<{0}{1}{3}>{2}</{0}>", tag, is_words(i) ? " class=\"words\"" : "", words,
                         name);
    }
    return row + "</tr>\n";
  };
  std::string out = fmt::format("<div class=\"scroll{}\"><table>\n<thead>{}</thead>\n<tbody>\n",
                                table.rows.size() <= rows_of_a_short_one ? " short" : "",
                                row_of(table.header, "th", ""));
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    // A line between two drives.
    const bool begins =
        i > 0 && is_words(0) && is_words(1) && table.rows[i][0] != table.rows[i - 1][0];
    out += row_of(table.rows[i], "td", begins ? " class=\"first\"" : "");
  }
  return out + "</tbody></table></div>\n" + definitions_of(table);
}

std::string html_of(const std::vector<Figure>& figures, const char* kind = "") {
  std::string out = fmt::format("<div class=\"figures{}\">\n", kind);
  for (const Figure& figure : figures) {
    out += "<figure>\n" + chart::as_svg(std::array{figure.drawing});
    if (!figure.caption.empty())
      out += "<figcaption>" + escaped(figure.caption) + "</figcaption>\n";
    out += "</figure>\n";
  }
  return out + "</div>\n";
}

std::string paragraph(const std::string& text, const char* kind) {
  return fmt::format("<p class=\"{}\">{}</p>\n", kind, escaped(text));
}

// Facts about the drive and its evaluation, in one paragraph.
std::string facts(const EvaluatedDrive& drive) {
  const Evaluation& e = drive.report.evaluations.front();
  std::string text = fixed(static_cast<double>(e.last_ns - e.first_ns) * 1e-9, 1) + " s, " +
                     fixed(e.path_length, 1) + " m. ";
  text += "Reference: " + basis_in_words(drive.report);
  if (has_reference(e.against)) text += "; alignment " + align_in_words(drive.report.align);
  text += '.';
  if (e.against == Against::closed_loop && camera_came_in(drive) &&
      drive.report.frame == Frame::map)
    text += " With camera poses the error at the end is only as good as the camera.";
  if (drive.report.frame == Frame::odom) text += " The pose without jumps.";
  if (!drive.replays.empty()) {
    const ReplaySummary& summary = drive.replays.front().summary;
    text += " " + std::to_string(summary.frames) + " CAN frames, " +
            (summary.cameras > 0     ? std::to_string(summary.cameras) + " camera poses."
             : drive.cameras.empty() ? "no camera: dead reckoning."
                                     : "camera left out: dead reckoning.");
  }
  return paragraph(text, "faint");
}

// The focus's calibrations at the end of the drive.
std::optional<Table> calibration_table(const EvaluatedDrive& drive) {
  const std::size_t focus = focus_of(drive);
  if (focus >= drive.replays.size()) return std::nullopt;
  const odom_details& details = drive.replays[focus].last.details;
  static constexpr std::array<const char*, daemon::calibrations.size()> units{
      " [rad/s]", "", " [m/s²]", " [m/s²]", "", " [rad]", "", " [s]", " [s]", " [s]", " [m/s²]"};
  Table table{{"learnt", "value", "3σ", ""}, {}, {0, 3}};
  for (std::size_t i = 0; i < daemon::calibrations.size(); ++i) {
    const double sigma = daemon::calibration_sigma(details, i);
    if (!(sigma > 0.0)) continue;
    const bool valid = (details.calibration_valid >> i & 1U) != 0;
    table.rows.push_back({std::string{daemon::calibrations[i].name} + units[i],
                          fixed(details.*daemon::calibrations[i].value, 4), fixed(3.0 * sigma, 4),
                          valid ? "" : "not seen well enough"});
  }
  if (table.rows.empty()) return std::nullopt;
  return table;
}

std::string samples(const EvaluatedDrive& drive) {
  const std::size_t focus = focus_of(drive);
  if (focus >= drive.replays.size()) return {};
  std::string out = "<h3>Samples, as " + escaped(drive.estimates[focus].name) + " took them" +
                    (drive.is_part ? ", over the whole drive" : "") + "</h3>\n" +
                    html_of(source_table(drive.replays[focus].summary));
  const std::vector<Figure> figures = innovation_figures(drive);
  if (!figures.empty()) {
    out += paragraph(
        "Innovations: difference of each sample from what the filter expected at the sample's own "
        "time, with three standard deviations. Dense dots are thinned; the outermost remain. NIS "
        "is the mean of their squares over S; consistent is 1.",
        "faint");
    out += html_of(figures, " small");
  }
  if (const auto learnt = calibration_table(drive)) out += html_of(*learnt);
  return out;
}

std::string configuration(const EvaluatedDrive& drive) {
  if (!drive.config) return {};
  return fmt::format("<details><summary>Configuration: {}</summary>\n<pre>{}</pre></details>\n",
                     escaped(drive.config->file.string()), escaped(drive.config->text));
}

std::string section(const EvaluatedDrive& drive) {
  std::string out = "<h2>" + escaped(drive.name) + "</h2>\n" + facts(drive);
  for (const std::string& warning : texts_of(drive.warnings)) out += paragraph(warning, "warning");
  std::vector<Figure> figures{map_figure(drive)};
  for (Figure& figure : error_figures(drive)) figures.push_back(std::move(figure));
  out += html_of(figures);
  out += "<h3>All figures</h3>\n" + html_of(metrics_table(drive.report));
  out += samples(drive);
  if (drive.beat) out += "<h3>Beat</h3>\n" + html_of(beat_charts(*drive.beat), " small");
  return out + configuration(drive);
}

// The box at the top of the page.
std::string verdict(const EvaluatedDrive& drive, bool several) {
  const DriveVerdict verdict = verdict_of(drive);
  std::string kind = in_words(verdict.grade);
  std::ranges::replace(kind, ' ', '-');
  std::string out = fmt::format("<div class=\"verdict {}\"><p><b>{}</b>: {}{}.</p>\n<ul>\n", kind,
                                in_words(verdict.grade), several ? escaped(drive.name) + ", " : "",
                                escaped(verdict.subject));
  for (const Reason& reason : verdict.reasons)
    out += fmt::format("<li>{}{}</li>\n",
                       reason.grade == Grade::good ? "" : "<b>" + in_words(reason.grade) + "</b>: ",
                       escaped(reason.sentence));
  return out + "</ul>\n<p class=\"faint\">Compared with " + escaped(verdict.basis) +
         ".</p></div>\n";
}

}  // namespace

std::string page(std::span<const EvaluatedDrive> drives, const PageInfo& info) {
  const auto names = drives | std::views::transform(&EvaluatedDrive::name);
  const std::string title = escaped(
      info.title.empty() ? fmt::format("Odometry of {}", fmt::join(names, ", ")) : info.title);
  const Table summary = summary_table(drives);
  std::string body = "<h1>" + title + "</h1>\n";
  for (const EvaluatedDrive& drive : drives) body += verdict(drive, drives.size() > 1);
  body += html_of(summary);
  body += paragraph(
      "The baseline is " + names_of(drives.front())[drives.front().report.baseline] + ".", "faint");
  for (const EvaluatedDrive& drive : drives)
    body += "<section>\n" + section(drive) + "</section>\n";
  body += fmt::format(
      "<h2>How this was made</h2>\n<p class=\"faint\">odom {}</p>\n<p><code>{}</code></p>\n",
      escaped(info.version), escaped(info.command));
  return fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      title, style, body);
}

}  // namespace odomd::tools::report
