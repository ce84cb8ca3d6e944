#include "tools/identify/stiffness/marker_track.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r\"";
  const std::size_t begin = text.find_first_not_of(blank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blank) - begin + 1);
}

// "x_front (px)" is "x_front".
std::string column_name(std::string_view text) {
  std::string name{trimmed(text)};
  name.resize(std::min({name.find_first_of(" (["), name.size()}));
  for (char& letter : name)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return name;
}

char separator_of(std::string_view line) {
  for (const char separator : {'\t', ';', ','})
    if (line.find(separator) != std::string_view::npos) return separator;
  return ' ';
}

std::vector<std::string> split(std::string_view line, char separator) {
  std::vector<std::string> fields;
  while (true) {
    const std::size_t end = line.find(separator);
    const std::string_view field = trimmed(line.substr(0, end));
    if (separator != ' ' || !field.empty()) fields.emplace_back(field);
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Decimal commas become points.
std::string with_points(std::string field, char separator) {
  if (separator != ',') std::ranges::replace(field, ',', '.');
  return field;
}

bool begins_with_number(std::string_view line) {
  const char separator = separator_of(line);
  const std::vector<std::string> fields = split(line, separator);
  return !fields.empty() && parse_number(with_points(fields.front(), separator)).has_value();
}

struct Row {
  std::int64_t t_ns = 0;
  std::array<std::optional<double>, 4> values;  // as many as were asked for
};

struct Table {
  std::string name;
  std::vector<Row> rows;
};

class TrackReader {
 public:
  TrackReader(const std::filesystem::path& file, std::span<const std::string_view> columns,
              const FilmTime& time)
      : input_(open_input(file)), columns_(columns), time_(time) {
    table_.name = file.string();
  }

  Table read() {
    std::string headings;
    for (std::string line; read_line(line);) {
      if (line_number_ == 1 && line.starts_with("\xEF\xBB\xBF"))
        line.erase(0, 3);  // byte order mark
      const std::string_view text = trimmed(line);
      if (text.empty() || text.starts_with('#')) continue;
      if (positions_.empty()) {
        if (!begins_with_number(line)) {
          headings = line;
          continue;
        }
        find_columns(headings, line);
      }
      take(line);
    }
    if (input_.bad()) throw std::runtime_error(table_.name + ": cannot be read");
    if (table_.rows.empty())
      throw std::invalid_argument(table_.name +
                                  ": contains no row that begins with a number; export "
                                  "the track as a table with the columns " +
                                  wanted());
    return std::move(table_);
  }

 private:
  [[nodiscard]] std::string wanted() const {
    std::string names;
    for (const std::string_view column : columns_)
      names += (names.empty() ? "" : ",") + std::string(column);
    return names;
  }

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
    throw std::invalid_argument(fmt::format("{}:{}: {}", table_.name, line_number_, what));
  }

  void find_columns(const std::string& headings, const std::string& first_row) {
    separator_ = separator_of(first_row);
    std::vector<std::string> names;
    if (!headings.empty()) {
      for (const std::string& field : split(headings, separator_of(headings)))
        names.push_back(column_name(field));
    } else if (columns_.size() == 3) {
      names.assign(columns_.begin(), columns_.end());
    }
    for (const std::string_view column : columns_) {
      const auto found = std::ranges::find(names, column);
      if (found == names.end())
        fail(fmt::format("there is no column \"{}\" in the header; the columns must be {}", column,
                         wanted()));
      positions_.push_back(static_cast<std::size_t>(found - names.begin()));
    }
  }

  void take(const std::string& line) {
    const std::vector<std::string> fields = split(line, separator_);
    const auto field = [&](std::size_t column) {
      const std::size_t position = positions_[column];
      return position < fields.size() ? with_points(fields[position], separator_) : std::string{};
    };
    Row row;
    row.t_ns = parse_time(field(0));
    if (!table_.rows.empty() && row.t_ns <= table_.rows.back().t_ns)
      fail(
          fmt::format("column \"{}\": {} is not later than the row before; sort the rows by time "
                      "and remove repeated ones",
                      columns_[0], tools::quoted(field(0))));
    for (std::size_t k = 1; k < columns_.size(); ++k) {
      const std::string text = field(k);
      if (text.empty()) continue;
      const std::optional<double> value = parse_number(text);
      if (!value || !std::isfinite(*value))
        fail(
            fmt::format("column \"{}\": {} is not a finite number; leave the field empty if the "
                        "marker was not seen",
                        columns_[k], tools::quoted(text)));
      row.values[k - 1] = value;
    }
    table_.rows.push_back(row);
  }

  [[nodiscard]] std::int64_t parse_time(const std::string& text) const {
    if (time_.frames_per_second) {
      const std::optional<double> frame = parse_number(text);
      if (!frame || !(std::abs(*frame) < 1e9) || *frame != std::floor(*frame))
        fail(fmt::format("column \"{}\": {} is not a frame number, which --fps requires",
                         columns_[0], tools::quoted(text)));
      return std::llround(1e9 * *frame / *time_.frames_per_second);
    }
    const std::optional<std::int64_t> time = parse_seconds(text);
    if (!time)
      fail(fmt::format("column \"{}\": {} is not a time in seconds; correct or remove the line",
                       columns_[0], tools::quoted(text)));
    return *time;
  }

  std::ifstream input_;
  std::span<const std::string_view> columns_;
  FilmTime time_;
  Table table_;
  std::size_t line_number_ = 0;
  char separator_ = ',';
  std::vector<std::size_t> positions_;
};

}  // namespace

MarkerTrack read_marker_track(const std::filesystem::path& file, const FilmTime& time) {
  constexpr std::array<std::string_view, 5> columns{"t", "x_front", "y_front", "x_rear", "y_rear"};
  Table table = TrackReader(file, columns, time).read();
  MarkerTrack track{std::move(table.name), {}, 0};
  for (const Row& row : table.rows) {
    const auto& v = row.values;
    if (v[0] && v[1] && v[2] && v[3])
      track.frames.push_back({row.t_ns, Plane{*v[0], *v[1]}, Plane{*v[2], *v[3]}});
    else
      ++track.gaps;
  }
  return track;
}

MarkerTrack read_marker_tracks(const std::filesystem::path& front,
                               const std::filesystem::path& rear, const FilmTime& time) {
  constexpr std::array<std::string_view, 3> columns{"t", "x", "y"};
  const Table a = TrackReader(front, columns, time).read();
  const Table b = TrackReader(rear, columns, time).read();
  MarkerTrack track{a.name, {}, 0};
  auto other = b.rows.begin();
  for (const Row& row : a.rows) {
    while (other != b.rows.end() && other->t_ns < row.t_ns) ++other;
    const bool both = other != b.rows.end() && other->t_ns == row.t_ns && row.values[0] &&
                      row.values[1] && other->values[0] && other->values[1];
    if (both)
      track.frames.push_back({row.t_ns, Plane{*row.values[0], *row.values[1]},
                              Plane{*other->values[0], *other->values[1]}});
    else
      ++track.gaps;
  }
  if (track.frames.empty())
    throw std::invalid_argument(fmt::format(
        "{} and {} have no time in common; export both from the same film", a.name, b.name));
  return track;
}

}  // namespace odomd::tools
