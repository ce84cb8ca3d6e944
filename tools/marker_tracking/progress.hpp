// The progress on a terminal.
#pragma once

#include <cstdint>

namespace odomd::tools {

class FrameProgress {
 public:
  explicit FrameProgress(bool always);
  ~FrameProgress();
  FrameProgress(const FrameProgress&) = delete;
  FrameProgress& operator=(const FrameProgress&) = delete;

  void update(std::int64_t frame, std::int64_t total, std::int64_t found);

 private:
  bool shown_;
  bool drawn_ = false;
};

}  // namespace odomd::tools
