#include "tools/drive_files/pose_file.hpp"

#include <ostream>

#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

constexpr std::size_t batch = 2048;  // rows: enough that starting a thread for them is cheap

}  // namespace

PoseFile::PoseFile(std::ostream& out) : out_(out) {
  added_.reserve(batch);
  write_record_header(out_);
}

PoseFile::~PoseFile() = default;

void PoseFile::add(const daemon::TickRecord& record, std::int64_t t_ns) {
  added_.push_back({record, t_ns});
  if (added_.size() == batch) hand_over();
}

void PoseFile::finish() {
  hand_over();
  writing_.get();
}

void PoseFile::hand_over() {
  if (writing_.valid()) writing_.get();
  written_.swap(added_);
  added_.clear();
  writing_ = std::async([this] {
    text_.clear();
    for (const Row& row : written_) append_record_row(text_, row.record, row.t_ns);
    out_ << text_;
  });
}

}  // namespace odomd::tools
