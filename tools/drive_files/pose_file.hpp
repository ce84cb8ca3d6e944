// Writes a pose file. A separate thread formats the rows, so that a replay does not wait for its
// output.
#pragma once

#include <cstdint>
#include <future>
#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/core/record.hpp"

namespace odomd::tools {

/// Rows come out in the order in which they were added. One thread.
class PoseFile {
 public:
  /// Writes the header. `out` belongs to this object until finish() or its destruction.
  explicit PoseFile(std::ostream& out);
  ~PoseFile();  ///< without finish(): the last rows may be missing
  PoseFile(const PoseFile&) = delete;
  PoseFile& operator=(const PoseFile&) = delete;

  /// `t_ns` is the time of validity on the clock of the file.
  void add(const daemon::TickRecord& record, std::int64_t t_ns);
  /// Returns when all rows are in `out`.
  void finish();

 private:
  struct Row {
    daemon::TickRecord record;
    std::int64_t t_ns;
  };
  void hand_over();

  std::ostream& out_;
  std::vector<Row> added_;
  std::vector<Row> written_;  // these two belong to the writing thread
  std::string text_;
  std::future<void> writing_;  // declared last: its destructor waits for the thread
};

}  // namespace odomd::tools
