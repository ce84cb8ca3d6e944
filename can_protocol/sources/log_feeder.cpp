// All waits sleep in poll(2), which also watches the stop event.
#include "can_protocol/sources/log_feeder.hpp"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "base/seconds.hpp"
#include "base/wall_clock.hpp"
#include "can_protocol/sources/frame_receiver.hpp"
#include "can_protocol/sources/log_reader.hpp"

namespace odomd::can {
namespace {

constexpr std::int64_t ring_full_wait_ns = 2'000'000;
constexpr std::int64_t oldest_line_ns = 10 * ns_per_s;
constexpr std::int64_t long_pause_ns = 600 * ns_per_s;

bool is_pipe(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode);
}

/// The time from reading the first frame to its release. For a file, it lets the reader run ahead;
/// for a pipe, which may be live, it is short, since it adds latency.
std::int64_t head_start(bool pipe, std::int64_t period_ns) {
  return pipe ? 2 * period_ns : LogFeeder::ahead_ns;
}

/// Signals are handled by another thread.
class AllSignalsBlocked {
 public:
  AllSignalsBlocked() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  AllSignalsBlocked(const AllSignalsBlocked&) = delete;
  AllSignalsBlocked& operator=(const AllSignalsBlocked&) = delete;
  ~AllSignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_{};
};

}  // namespace

LogFeeder::LogFeeder(std::string path, BusNames& buses, LogClock& clock, FrameSelection selected)
    : path_(std::move(path)),
      label_(log_label(path_)),
      clock_(clock),
      file_(open_log(path_, FifoOpening::non_blocking)),
      stop_(::eventfd(0, EFD_CLOEXEC)),
      pipe_(is_pipe(file_.get())),
      lead_ns_(head_start(pipe_, clock.period_ns())),
      lines_(label_, buses),
      selected_(std::move(selected)),
      stamps_(label_, pipe_ ? LogStamps::Judging::live : LogStamps::Judging::offline),
      arrivals_(clock, lead_ns_, pipe_ahead_ns + lead_ns_) {
  if (!stop_) throw std::system_error(errno, std::generic_category(), label_ + ": eventfd");
  const AllSignalsBlocked blocked;
  thread_ = std::thread([this] { run(); });
  ::pthread_setname_np(thread_.native_handle(), "odomd-feeder");
}

LogFeeder::~LogFeeder() {
  ::eventfd_write(stop_.get(), 1);
  thread_.join();
}

// The beat's side ---------------------------------------------------------------------------------

std::size_t LogFeeder::drain(std::span<Frame> frames, std::int64_t tick_ns,
                             std::int64_t /*now_ns*/) noexcept {
  std::size_t count = 0;
  const Frame* frame = nullptr;
  const std::int64_t advance_ns = clock_.advance_ns();
  const auto released = [advance_ns](const Frame& f) {
    return f.time_ns == 0 ? 0 : f.time_ns - advance_ns;
  };
  while ((frame = ring_.front()) != nullptr && released(*frame) <= tick_ns) {
    if (count == frames.size()) {
      counters_.carried_over.add();
      break;
    }
    frames[count] = *frame;
    frames[count++].time_ns = released(*frame);
    ring_.pop();
  }
  counters_.received.add(count);
  return count;
}

LinkState LogFeeder::link() const noexcept {
  // Read in this order, because the last frames were pushed before the flag was set.
  return finished_.load(std::memory_order_acquire) && ring_.empty() ? LinkState::ended
                                                                    : LinkState::up;
}

// The thread's side -------------------------------------------------------------------------------

void LogFeeder::run() noexcept {
  try {
    feed();
  } catch (const LogError& error) {
    warnings_.add(SourceWarning::failure, error.what());
  } catch (const std::exception& error) {
    warnings_.add(SourceWarning::failure, label_ + ": " + error.what());
  }
  finished_.store(true, std::memory_order_release);
}

void LogFeeder::feed() {
  while (const LoggedFrame* const logged = next()) {
    Frame frame = logged->frame;
    line_ = logged->line;
    if (frame.time_ns != 0) {
      follow_step(frame);
      const std::int64_t base_ns = clock_.start(frame.time_ns, earliest_release(frame));
      follow_arrivals(frame);
      frame.time_ns -= base_ns;
      const std::int64_t release_ns = frame.time_ns - clock_.advance_ns();
      const std::int64_t pause_ns = release_ns - monotonic_now();
      if (pause_ns > long_pause_ns)
        warnings_.add(SourceWarning::long_pause, place() + "the time stamps jump ahead by " +
                                                     std::to_string(pause_ns / ns_per_s) +
                                                     " s, and odomd waits that long; cut the log "
                                                     "at the pause");
      // Runs ahead in steps of half the window, so that one wake-up reads many frames.
      if (pause_ns > reads_ahead_ns() &&
          wait_until(release_ns - reads_ahead_ns() / 2) == Waited::stopped)
        return;
    }
    while (!ring_.push(frame))
      if (wait_until(monotonic_now() + ring_full_wait_ns) == Waited::stopped) return;
  }
}

void LogFeeder::check_one_stamp(std::uint64_t min_frames) {
  if (std::string text = stamps_.describe_one_stamp(min_frames); !text.empty())
    warnings_.add(SourceWarning::one_stamp, std::move(text));
}

/// Now plus the head start. The first line of a pipe may be older, because it was delayed or waited
/// in the pipe. If its stamp is from this machine's wall clock, its age is known and subtracted.
std::int64_t LogFeeder::earliest_release(const Frame& first) const {
  const std::int64_t age_ns = pipe_ ? read_clock(CLOCK_REALTIME) - first.time_ns : 0;
  const bool known = age_ns > 0 && age_ns < oldest_line_ns;
  return monotonic_now() + lead_ns_ - (known ? age_ns : 0);
}

void LogFeeder::follow_arrivals(const Frame& frame) {
  if (!pipe_ || !input_was_empty_) return;
  const std::int64_t by_ns = arrivals_.take(frame.time_ns, monotonic_now());
  if (by_ns == 0) return;
  const std::string by =
      label_ + ": lines arrive " + std::to_string(std::abs(by_ns) / 1'000'000) + " ms ";
  if (by_ns > 0)
    warnings_.add(SourceWarning::earlier_lines,
                  by + "earlier than before relative to their time stamps: the first one was late, "
                       "or their clock is fast or was stepped; the log clock follows, and the time "
                       "in between is lost");
  else
    warnings_.add(SourceWarning::later_lines,
                  by +
                      "later than before relative to their time stamps: their clock is slow or was "
                      "stepped; the log clock follows");
}

void LogFeeder::follow_step(const Frame& frame) {
  const std::int64_t now_ns = monotonic_now();
  const auto step_ns = live_stamps_.step(frame.time_ns, now_ns);
  if (!step_ns || !clock_.offset_ns()) return;
  clock_.restart(frame.time_ns, now_ns + lead_ns_);
  arrivals_.restart();
  counters_.clock_steps.add();
  warnings_.add(SourceWarning::clock_step,
                place() + "the clock of the time stamps was stepped by " +
                    std::to_string(*step_ns / ns_per_s) + " s; following it from here on");
}

const LoggedFrame* LogFeeder::next() {
  for (;;) {
    if (const LoggedFrame* const frame = stamps_.next()) return frame;
    if (stamps_.ended()) return nullptr;
    if (input_ended_) {
      stamps_.end();
      check_one_stamp(2);
      if (std::string text = stamps_.warning(); !text.empty())
        warnings_.add(SourceWarning::lone_stamps, std::move(text));
    } else if (!read_line()) {
      return nullptr;
    }
  }
}

/// Returns false if the thread must end.
bool LogFeeder::read_line() {
  if (const auto text = buffer_.next_line()) {
    take(*text, LineEnd::newline);
    return true;
  }
  if (wait_for_input() == Waited::stopped) return false;
  switch (buffer_.fill(file_.get())) {
    case LineBuffer::Fill::data:
      if (buffer_.line_number() > 0) break;
      if (const auto format = describe_foreign_format(buffer_.rest()))
        warnings_.add(SourceWarning::foreign_format, label_ + ": " + *format);
      break;
    case LineBuffer::Fill::again:
      break;
    case LineBuffer::Fill::error:
      warnings_.add(SourceWarning::failure,
                    label_ + ": reading failed: " + std::generic_category().message(errno));
      [[fallthrough]];
    case LineBuffer::Fill::end:
      input_ended_ = true;
      if (const auto text = buffer_.last_line()) take(*text, LineEnd::end_of_log);
  }
  return true;
}

void LogFeeder::take(std::string_view text, LineEnd end) {
  Frame frame;
  switch (const LineKind kind = lines_.read(text, buffer_.line_number(), end, frame)) {
    case LineKind::frame:
      break;
    case LineKind::blank:
      return;
    case LineKind::passed_over:
    case LineKind::damaged:
    case LineKind::cut_off:
    case LineKind::bus_too_many:
      counters_.malformed.add();
      warnings_.add(kind == LineKind::bus_too_many ? SourceWarning::too_many_buses
                    : kind == LineKind::damaged    ? SourceWarning::damaged_line
                                                   : SourceWarning::malformed_line,
                    lines_.problem());
      return;
  }
  if (frame.kind == FrameKind::error) {
    count_error_frame(frame, counters_);
    return;
  }
  if (selected_ && !selected_(frame)) return;
  stamps_.add(frame, buffer_.line_number());
  check_one_stamp(too_many_with_one_stamp);
}

LogFeeder::Waited LogFeeder::wait_for_input() {
  std::array<pollfd, 2> events{pollfd{file_.get(), POLLIN, 0}, pollfd{stop_.get(), POLLIN, 0}};
  const bool ready = ::poll(events.data(), events.size(), 0) > 0;
  input_was_empty_ = !ready;
  live_stamps_.read(ready ? LiveStamps::Input::ready : LiveStamps::Input::waited_for);
  if (!ready) ::poll(events.data(), events.size(), -1);
  return events[1].revents != 0 ? Waited::stopped : Waited::due;
}

LogFeeder::Waited LogFeeder::wait_until(std::int64_t monotonic_ns) const {
  for (;;) {
    const std::int64_t rest = monotonic_ns - monotonic_now();
    if (rest <= 0) return Waited::due;
    const timespec timeout{rest / ns_per_s, rest % ns_per_s};
    pollfd stop{stop_.get(), POLLIN, 0};
    if (::ppoll(&stop, 1, &timeout, nullptr) > 0) return Waited::stopped;
  }
}

}  // namespace odomd::can
