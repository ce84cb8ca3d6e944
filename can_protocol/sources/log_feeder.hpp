// A candump log, or standard input, as a live bus: a thread reads it and releases each frame at the
// time of its stamp.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/file_descriptor.hpp"
#include "base/spsc_ring.hpp"
#include "can_protocol/bus_names.hpp"
#include "can_protocol/sources/arrivals.hpp"
#include "can_protocol/sources/frame_source.hpp"
#include "can_protocol/sources/log_lines.hpp"
#include "can_protocol/sources/log_stamps.hpp"
#include "can_protocol/sources/source_warnings.hpp"

namespace odomd::can {

/// The thread runs from construction to destruction and passes frames through a ring, up to
/// `ahead_ns` before they are due (`pipe_ahead_ns` for a pipe); the drain holds them back until a
/// tick is due. A frame whose time has passed (the input is late, or its stamps go backwards) is
/// released immediately; at a gap the thread waits. The stamp zero means none: the frame is
/// released immediately with time 0. Error frames are counted, but not delivered. For a live pipe,
/// a step of the clock behind its stamps is detected and followed, and so are lines that come
/// earlier or later relative to their stamps than before (arrivals.hpp).
///
/// Lines, frames and their stamps are judged as MergedLog judges them, so that a replay uses the
/// same frames; but a stamp in a pipe is judged without later ones. Lines without a frame are
/// counted as malformed. At the end of the input, when the ring is empty, the link is `ended`.
class LogFeeder final : public FrameSource {
 public:
  static constexpr std::int64_t ahead_ns = 50'000'000;
  /// The maximum delay of the first line relative to the others. Lines are read this long before
  /// their release, not left in the pipe.
  static constexpr std::int64_t pipe_ahead_ns = 1'000'000'000;

  /// `path` may be "-" and may be a FIFO. `buses` and `clock` must outlive this. Only `selected`
  /// frames are released, and only their stamps move the clock. Throws LogError when the log cannot
  /// be opened or is of another format.
  LogFeeder(std::string path, BusNames& buses, LogClock& clock, FrameSelection selected = {});
  ~LogFeeder() override;
  LogFeeder(const LogFeeder&) = delete;
  LogFeeder& operator=(const LogFeeder&) = delete;

  std::size_t drain(std::span<Frame> frames, std::int64_t tick_ns,
                    std::int64_t now_ns) noexcept override;
  [[nodiscard]] LinkState link() const noexcept override;
  [[nodiscard]] const SourceCounters& counters() const noexcept override { return counters_; }
  [[nodiscard]] const std::string& name() const noexcept override { return path_; }

  /// Log clock - CLOCK_MONOTONIC; empty before the first frame. Any thread.
  [[nodiscard]] std::optional<std::int64_t> log_offset_ns() const noexcept {
    return clock_.offset_ns();
  }

  [[nodiscard]] std::vector<std::string> warnings() const override { return warnings_.list(); }

 private:
  enum class Waited : std::uint8_t { due, stopped };
  static constexpr std::size_t ring_capacity = 8192;
  static constexpr std::uint64_t too_many_with_one_stamp = 500;

  void run() noexcept;
  void feed();
  void check_one_stamp(std::uint64_t min_frames);
  void follow_step(const Frame& frame);
  void follow_arrivals(const Frame& frame);
  [[nodiscard]] std::int64_t earliest_release(const Frame& first) const;
  [[nodiscard]] std::int64_t reads_ahead_ns() const { return pipe_ ? pipe_ahead_ns : ahead_ns; }
  [[nodiscard]] const LoggedFrame* next();
  bool read_line();
  void take(std::string_view text, LineEnd end);
  [[nodiscard]] std::string place() const { return at_line(label_, line_); }
  Waited wait_for_input();
  Waited wait_until(std::int64_t monotonic_ns) const;

  std::string path_;
  std::string label_;
  LogClock& clock_;
  FileDescriptor file_;
  FileDescriptor stop_;       // an eventfd: readable when the thread must end
  bool pipe_ = false;         // not a regular file
  std::int64_t lead_ns_ = 0;  // head start of the first frame
  SourceCounters counters_;   // the drain counts received and carried_over, the thread the rest

  // Used by the thread only.
  LineBuffer buffer_;
  LogLines lines_;
  FrameSelection selected_;
  LogStamps stamps_;
  std::uint64_t line_ = 0;  // of the current frame
  LiveStamps live_stamps_;
  Arrivals arrivals_;
  bool input_was_empty_ = false;  // before the current lines came
  bool input_ended_ = false;

  SourceWarnings warnings_;
  std::atomic<bool> finished_{false};  // the thread pushes no more frames
  SpscRing<Frame, ring_capacity> ring_;
  std::thread thread_;
};

}  // namespace odomd::can
