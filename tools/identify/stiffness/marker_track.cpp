#include "tools/identify/stiffness/film.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
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

// "x_front (px)" is "x_front".
std::string column_name(std::string name) {
  name.resize(std::min(name.find_first_of(" (["), name.size()));
  for (char& letter : name)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return name;
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct Row {
  std::int64_t t_ns = 0;
  std::vector<std::optional<double>> values;  // of the columns but the first
};

class TrackReader {
 public:
  TrackReader(const std::filesystem::path& file, std::vector<std::string> columns,
              const FilmTime& time)
      : name_(file.string()), input_(open_input(file)), columns_(std::move(columns)), time_(time) {}

  std::vector<Row> read() {
    std::vector<std::string> headings;
    for (std::string line; read_line(line);) {
      if (line_number_ == 1 && line.starts_with("\xEF\xBB\xBF"))
        line.erase(0, 3);  // byte order mark
      const std::string_view text = trimmed(line);
      if (text.empty() || text.starts_with('#')) continue;
      std::vector<std::string> fields = fields_of(line);
      if (positions_.empty() && (fields.empty() || !parse_number(fields.front()))) {
        headings = std::move(fields);
        continue;
      }
      if (positions_.empty()) find_columns(std::move(headings));
      take(fields);
    }
    if (input_.bad()) throw std::runtime_error(name_ + ": cannot be read");
    if (rows_.empty())
      refuse(
          "{}: contains no row that begins with a number; export the track as a table "
          "with the columns {}",
          name_, fmt::join(columns_, ","));
    return std::move(rows_);
  }

 private:
  // A file without line ends must not fill the memory.
  bool read_line(std::string& line) {
    constexpr std::size_t longest = 65'536;
    line.clear();
    int letter = 0;
    while ((letter = input_.get()) != std::ifstream::traits_type::eof()) {
      if (line.empty()) ++line_number_;
      if (letter == '\n') return true;
      if (line.size() == longest) fail("the line is longer than 64 KiB; is this a track?");
      line += static_cast<char>(letter);
    }
    return !line.empty();
  }

  [[noreturn]] void fail(const std::string& what) const {
    refuse("{}:{}: {}", name_, line_number_, what);
  }
  [[noreturn]] void fail(std::size_t column, const std::string& field, const char* what) const {
    fail(fmt::format("column \"{}\": {} {}", columns_[column], tools::quoted(field), what));
  }

  void find_columns(std::vector<std::string> names) {
    if (names.empty() && columns_.size() == 3) names = columns_;
    for (std::string& name : names) name = column_name(std::move(name));
    for (const std::string& column : columns_) {
      const auto found = std::ranges::find(names, column);
      if (found == names.end())
        fail(fmt::format("there is no column \"{}\" in the header; the columns must be {}", column,
                         fmt::join(columns_, ",")));
      positions_.push_back(static_cast<std::size_t>(found - names.begin()));
    }
  }

  void take(std::vector<std::string> fields) {
    fields.resize(std::max(fields.size(), std::ranges::max(positions_) + 1));
    Row row{.t_ns = parse_time(fields[positions_[0]])};
    if (!rows_.empty() && row.t_ns <= rows_.back().t_ns)
      fail(0, fields[positions_[0]],
           "is not later than the row before; sort the rows by time and remove repeated ones");
    for (std::size_t k = 1; k < columns_.size(); ++k) {
      const std::string& field = fields[positions_[k]];
      const std::optional<double> value = row.values.emplace_back(parse_number(field));
      if (!field.empty() && (!value || !std::isfinite(*value)))
        fail(k, field, "is not a finite number; leave the field empty if the marker was not seen");
    }
    rows_.push_back(std::move(row));
  }

  [[nodiscard]] std::int64_t parse_time(const std::string& field) const {
    if (time_.frames_per_second) {
      const std::optional<double> frame = parse_number(field);
      if (!frame || !(std::abs(*frame) < 1e9) || *frame != std::floor(*frame))
        fail(0, field, "is not a frame number, which --fps requires");
      return std::llround(1e9 * *frame / *time_.frames_per_second);
    }
    const std::optional<std::int64_t> time = parse_seconds(field);
    if (!time) fail(0, field, "is not a time in seconds; correct or remove the line");
    return *time;
  }

  std::string name_;
  std::ifstream input_;
  std::vector<std::string> columns_;
  FilmTime time_;
  std::vector<Row> rows_;
  std::size_t line_number_ = 0;
  std::vector<std::size_t> positions_;  // of columns_ in a row
};

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

MarkerTrack read_marker_track(const std::filesystem::path& file, const FilmTime& time) {
  return track_of(file,
                  TrackReader(file, {"t", "x_front", "y_front", "x_rear", "y_rear"}, time).read());
}

MarkerTrack read_marker_tracks(const std::filesystem::path& front,
                               const std::filesystem::path& rear, const FilmTime& time) {
  std::vector<Row> both = TrackReader(front, {"t", "x", "y"}, time).read();
  const std::vector<Row> others = TrackReader(rear, {"t", "x", "y"}, time).read();
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
