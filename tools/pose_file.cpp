#include "tools/pose_file.hpp"

#include <ostream>

#include "tools/pose_csv.hpp"

namespace odomd::tools {
namespace {

constexpr std::size_t batch = 2048;  // rows: enough that starting a thread for them is nothing

}  // namespace

PoseFile::PoseFile(std::ostream& out) : out_(out) {
  added_.reserve(batch);
  write_pose_header(out_);
}

PoseFile::~PoseFile() = default;

void PoseFile::add(const odom_pose& pose, std::int64_t t_ns) {
  added_.push_back({pose, t_ns});
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
    for (const Row& row : written_) append_pose_row(text_, row.pose, row.t_ns);
    out_ << text_;
  });
}

}  // namespace odomd::tools
