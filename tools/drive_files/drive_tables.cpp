#include "tools/drive_files/drive_tables.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/cli/files.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::tools {

using diagnostics::found;

CsvReader camera_reader(std::istream& input, const std::string& name) {
  return {input, name, names_of<estimator::CameraPose>(camera_columns), LastLine::drop_unended};
}

std::optional<estimator::CameraPose> next_camera_pose(CsvReader& reader) {
  if (!reader.next()) return std::nullopt;
  const auto pose = read_row<estimator::CameraPose>(reader, camera_columns);
  std::size_t column = 5;
  for (const double sigma : {pose.sigma_x, pose.sigma_y, pose.sigma_yaw}) {
    if (!(sigma > 0.0))
      reader.fail(column, "a standard deviation must be above 0; correct or remove the line");
    ++column;
  }
  return pose;
}

CameraLog read_camera_log(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader = camera_reader(input, file.string());
  CameraLog log;
  while (const auto pose = next_camera_pose(reader)) {
    log.poses.push_back(*pose);
  }
  append(log.warnings, kind("file_content"), reader.warnings());

  const auto before_seen = std::ranges::count_if(
      log.poses, [](const auto& pose) { return pose.arrival_ns < pose.capture_ns; });
  if (before_seen > 0)
    log.warnings.push_back(
        found(kind("camera_columns_exchanged"), file.string(),
              fmt::format("{} of {} poses arrive before they are captured and cannot be used",
                          before_seen, log.poses.size())));

  const auto by_arrival = [](const estimator::CameraPose& a, const estimator::CameraPose& b) {
    return a.arrival_ns < b.arrival_ns;
  };
  if (!std::is_sorted(log.poses.begin(), log.poses.end(), by_arrival)) {
    std::stable_sort(log.poses.begin(), log.poses.end(), by_arrival);
    log.warnings.push_back(found(kind("file_content"), file.string(),
                                 "rows were not in the order of t_arrival; sorted"));
  }
  return log;
}

diagnostics::Diagnostic no_camera_pose(const std::filesystem::path& file) {
  return found(kind("no_camera_pose"), file.string(), "contains no camera pose");
}

namespace {

std::size_t bucket_of(std::int64_t ns) {
  const double us = static_cast<double>(ns) * 1e-3;
  if (us < 1.0) return 0;
  const auto bucket = 1 + static_cast<std::size_t>(std::floor(4.0 * std::log2(us) + 1e-9));
  return std::min<std::size_t>(bucket, ODOM_HISTOGRAM_BUCKETS - 1);
}

}  // namespace

odom_beat read_beat_log(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader{input,
                   file.string(),
                   names_of<BeatRow>(beat_columns),
                   LastLine::drop_unended,
                   {.required = 3}};
  odom_beat beat{};
  BeatRow before;
  while (reader.next()) {
    const auto row = read_row<BeatRow>(reader, beat_columns);
    if (beat.ticks > 0) {
      if (row.tick <= before.tick)
        reader.fail(0, "the tick number does not increase; sort the rows by tick");
      beat.missed += row.tick - before.tick - 1;
    }
    before = row;
    const std::int64_t late_ns = row.woke_ns - row.time_ns;
    beat.max_wakeup_ns = std::max(beat.max_wakeup_ns, late_ns);
    ++beat.wakeup[bucket_of(late_ns)];
    ++beat.ticks;
  }
  if (beat.ticks == 0) {
    throw std::invalid_argument(file.string() + ": has no rows");
  }
  return beat;
}

BucketEdges edges_of(std::size_t bucket) {
  const auto i = static_cast<double>(bucket);
  return {bucket == 0 ? std::exp2(-0.25) : std::exp2(0.25 * (i - 1.0)), std::exp2(0.25 * i)};
}

double percentile_us(BeatBuckets buckets, double share, std::int64_t max_ns) {
  const auto total = std::accumulate(buckets.begin(), buckets.end(), std::uint64_t{0});
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
  const double max_us = static_cast<double>(max_ns) * 1e-3;
  std::uint64_t sum = 0;
  for (std::size_t bucket = 0; bucket + 1 < buckets.size(); ++bucket) {
    sum += buckets[bucket];
    if (sum >= wanted) return std::min(max_us, edges_of(bucket).high_us);
  }
  return max_us;
}

namespace {

using estimator::Judgement;

constexpr std::string_view unknown = " is unknown; use a file of odom replay --innovations";
constexpr std::array<std::string_view, 3> axes{"1", "2", "3"};
constexpr std::size_t degrees_column = 3, first_sigma_column = 7;

// The file contains the square roots of the variances.
constexpr auto innovation_columns = [](auto&& cell, auto& row) {
  cell("t", row.time_ns);
  cell("source", Word{row.source, estimator::source_names, unknown});
  cell("verdict", Word{row.verdict, estimator::verdict_names, unknown});
  cell("degrees", row.degrees);
  for (std::size_t i = 0; i < 3; ++i) cell("nu_", row.innovation[i], axes[i]);
  for (std::size_t i = 0; i < 3; ++i) cell("sigma_", row.variance[i], axes[i]);
  cell("nis", row.squared_ratio);
};

}  // namespace

std::string innovation_header() {
  return header_of<Judgement>(innovation_columns);
}

void append_innovation_rows(std::string& out, const Judgement& judgement) {
  Judgement row = judgement;
  for (double& variance : row.variance) variance = std::sqrt(std::max(variance, 0.0));
  for (std::uint32_t sample = 0; sample < judgement.count; ++sample)
    append_row(out, innovation_columns, row);
}

std::vector<Judgement> read_innovations(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader{input, file.string(), names_of<Judgement>(innovation_columns)};
  std::vector<Judgement> judgements;
  while (reader.next()) {
    auto one = read_row<Judgement>(reader, innovation_columns);
    if (one.degrees != 0 && one.degrees != 1 && one.degrees != 3)
      reader.fail(degrees_column, "must be 0, 1 or 3");
    for (std::size_t i = 0; i < 3; ++i) {
      if (one.variance[i] < 0.0)
        reader.fail(first_sigma_column + i, "a standard deviation is negative; correct the line");
      one.variance[i] *= one.variance[i];
    }
    judgements.push_back(one);
  }
  if (judgements.empty()) {
    throw std::invalid_argument(file.string() +
                                ": has no rows; only the full filter tests samples");
  }
  return judgements;
}

}  // namespace odomd::tools
