// A pose file being written: the rows are put into words in a thread of their own, so that a replay
// need not wait for its output.
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
  /// Writes the header. `out` is left to this object until finish(), or until it is gone.
  explicit PoseFile(std::ostream& out);
  ~PoseFile();  ///< without finish(): the last rows may be missing
  PoseFile(const PoseFile&) = delete;
  PoseFile& operator=(const PoseFile&) = delete;

  /// `t_ns` is the time of validity on the clock of the file.
  void add(const daemon::TickRecord& record, std::int64_t t_ns);
  /// Returns when `out` has them all.
  void finish();

 private:
  struct Row {
    daemon::TickRecord record;
    std::int64_t t_ns;
  };
  void hand_over();

  std::ostream& out_;
  std::vector<Row> added_;
  std::vector<Row> written_;  // these two are the writing thread's
  std::string text_;
  std::future<void> writing_;  // behind them: it waits for the thread
};

}  // namespace odomd::tools
