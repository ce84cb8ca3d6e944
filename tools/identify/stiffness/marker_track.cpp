#include "tools/identify/stiffness/film.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/identify/common/refuse.hpp"

namespace odomd::tools {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r\"";
  const std::size_t begin = text.find_first_not_of(blank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blank) - begin + 1);
}

// Fields are parted by the first of these that a line has; where commas do not, they are decimal
// ones.
std::vector<std::string> fields_of(std::string_view line) {
  char separator = ' ';
  for (const char other : {',', ';', '\t'})
    if (line.find(other) != std::string_view::npos) separator = other;
  std::vector<std::string> fields;
  for (std::size_t begin = 0, end = 0; end < line.size() || begin == 0; begin = end + 1) {
    end = std::min(line.find(separator, begin), line.size());
    std::string field{trimmed(line.substr(begin, end - begin))};
    if (separator != ',') std::ranges::replace(field, ',', '.');
    if (separator != ' ' || !field.empty()) fields.push_back(std::move(field));
  }
  return fields;
}

std::string_view without_plus(std::string_view number) {
  return number.substr(number.starts_with('+') ? 1 : 0);
}

// "x_front (px)" is "x_front".
std::string column_name(std::string name) {
  name.resize(std::min(name.find_first_of(" (["), name.size()));
  for (char& letter : name)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return name;
}

struct Table {
  std::string text;
  CsvLayout layout;
};

// The file as a CSV of our own with the same lines: headings but the last, and comments, are blank.
Table as_csv(const std::filesystem::path& file, const std::vector<std::string>& columns) {
  constexpr std::size_t longest = 65'536;  // a file without line ends is no track
  Table table;
  std::size_t heading_at = 0, line_number = 0, width = columns.size();
  if (columns.size() == 3) table.layout.header_line = 0;  // headings may lack
  std::vector<std::string> names;
  bool has_rows = false;
  std::istringstream lines(read_whole(file));
  for (std::string line; std::getline(lines, line); table.text += '\n') {
    if (++line_number == 1 && line.starts_with("\xEF\xBB\xBF"))
      line.erase(0, 3);  // byte order mark
    if (line.size() > longest)
      refuse("{}:{}: the line is longer than 64 KiB; is this a track?", file.string(), line_number);
    if (const auto text = trimmed(line); text.empty() || text.starts_with('#')) continue;
    std::vector<std::string> fields = fields_of(line);
    has_rows = has_rows || (!fields.empty() && parse_number(without_plus(fields.front())));
    if (!has_rows) {
      names = std::move(fields);
      heading_at = table.text.size();
      table.layout.header_line = line_number;
      width = names.size();
      continue;
    }
    fields.resize(width);
    table.text += joined(fields);
  }
  if (!has_rows)
    refuse(
        "{}: contains no row that begins with a number; export the track as a table with the "
        "columns {}",
        file.string(), joined(columns));
  std::ranges::transform(names, names.begin(), column_name);
  table.text.insert(heading_at, joined(names));
  return table;
}

struct Row {
  std::int64_t t_ns = 0;
  std::vector<std::optional<double>> values;  // of the columns but the first
};

std::int64_t time_in(const CsvReader& reader, std::optional<double> fps) {
  if (!fps) return reader.time_ns(0);
  const std::optional<double> frame = parse_number(reader.text(0));
  if (!frame || !(std::abs(*frame) < 1e9) || *frame != std::floor(*frame))
    reader.fail(0, tools::quoted(reader.text(0)) + " is not a frame number, which --fps requires");
  return std::llround(1e9 * *frame / *fps);
}

std::vector<Row> read_rows(const std::filesystem::path& file,
                           const std::vector<std::string>& columns, std::optional<double> fps) {
  const Table table = as_csv(file, columns);
  std::istringstream text(table.text);
  CsvReader reader(text, file.string(), columns, LastLine::keep_whole, table.layout);
  std::vector<Row> rows;
  while (reader.next()) {
    Row row{.t_ns = time_in(reader, fps)};
    if (!rows.empty() && row.t_ns <= rows.back().t_ns)
      reader.fail(0, tools::quoted(reader.text(0)) +
                         " is not later than the row before; sort the rows by time and remove "
                         "repeated ones");
    for (std::size_t k = 1; k < columns.size(); ++k) {
      const std::string_view field = reader.text(k);
      const auto value = row.values.emplace_back(parse_number(without_plus(field)));
      if (!field.empty() && !(value && std::isfinite(*value)))
        reader.fail(k, tools::quoted(field) +
                           " is not a finite number; leave the field empty if the marker was not "
                           "seen");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// Of rows with the places of both markers.
MarkerTrack track_of(const std::filesystem::path& file, const std::vector<Row>& rows) {
  MarkerTrack track{.name = file.string()};
  for (const Row& row : rows) {
    const auto& v = row.values;
    if (v.size() == 4 && v[0] && v[1] && v[2] && v[3])
      track.frames.push_back({row.t_ns, Plane{*v[0], *v[1]}, Plane{*v[2], *v[3]}});
    else
      ++track.gaps;
  }
  return track;
}

}  // namespace

MarkerTrack read_marker_track(const std::filesystem::path& file, std::optional<double> fps) {
  return track_of(file, read_rows(file, {"t", "x_front", "y_front", "x_rear", "y_rear"}, fps));
}

MarkerTrack read_marker_tracks(const std::filesystem::path& front,
                               const std::filesystem::path& rear, std::optional<double> fps) {
  std::vector<Row> both = read_rows(front, {"t", "x", "y"}, fps);
  const std::vector<Row> others = read_rows(rear, {"t", "x", "y"}, fps);
  for (Row& row : both)
    if (const auto other = std::ranges::lower_bound(others, row.t_ns, {}, &Row::t_ns);
        other != others.end() && other->t_ns == row.t_ns)
      row.values.insert(row.values.end(), other->values.begin(), other->values.end());
  MarkerTrack track = track_of(front, both);
  if (track.frames.empty())
    refuse("{} and {} have no time in common; export both from the same film", front.string(),
           rear.string());
  return track;
}

}  // namespace odomd::tools
