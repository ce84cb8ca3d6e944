#include "tools/replay/recording_verifier.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "daemon/core/recording_wire.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/recording_folder.hpp"

namespace odomd::tools {
namespace {

std::string_view field(std::string_view row, std::size_t index) {
  for (; index > 0 && !row.empty(); --index)
    row.remove_prefix(std::min(row.find(','), row.size() - 1) + 1);
  return row.substr(0, row.find(','));
}

/// The first columns of a row, as many as an older row has: columns are only added at the end.
std::string_view columns_as_in(std::string_view older, std::string_view row) {
  const std::size_t count = static_cast<std::size_t>(std::ranges::count(older, ',')) + 1;
  std::size_t end = 0;
  for (std::size_t i = 0; i < count && end < row.size(); ++i)
    end = std::min(row.find_first_of(",\n", end + 1), row.size());
  return row.substr(0, end);
}

}  // namespace

RecordingVerifier::RecordingVerifier(const std::filesystem::path& folder)
    : file_(folder / recorded_poses), poses_(open_input(file_)) {
  if (const std::string expected = record_header();
      !std::getline(poses_, header_) || columns_as_in(header_, expected) != header_) {
    throw std::invalid_argument(
        file_.string() + ": has other columns than this odom writes; use the odom of that time");
  }
}

void RecordingVerifier::take(const daemon::TickRecord& record, const BeatRow& live) {
  ++ticks_;
  if (difference_) return;
  std::optional<std::string> column;
  if (record.initialised) column = differing_column(record, live);
  if (!column && fmt::format("{:016x}", daemon::fingerprint(record)) != live.record)
    column = "a part of the record that is not in the pose file differs";
  if (!column) return;
  std::string t;
  append_seconds(t, live.time_ns);
  difference_ = fmt::format("tick {} (t = {}): {}", live.tick, t, *column);
}

// Most numbers are written in the shortest form that reads back to the same bits: equal rows mean
// equal bits. The fingerprint covers the rest.
std::optional<std::string> RecordingVerifier::differing_column(const daemon::TickRecord& record,
                                                               const BeatRow& live) {
  std::string recorded;
  // A row without a newline was cut off when the machine failed; it is not compared.
  if (!std::getline(poses_, recorded) || poses_.eof()) return std::nullopt;
  ++rows_;
  std::string replayed;
  append_record_row(replayed, record, live.time_ns);
  replayed.resize(columns_as_in(header_, replayed).size());
  if (replayed == recorded) return std::nullopt;
  std::size_t column = 0;
  while (field(replayed, column) == field(recorded, column)) ++column;
  return fmt::format("{} is {}, live it was {}", field(header_, column), field(replayed, column),
                     field(recorded, column));
}

}  // namespace odomd::tools
