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
#include <ctime>
#include <system_error>
#include <utility>

#include "can_protocol/sources/kernel_frame.hpp"
#include "can_protocol/sources/log_reader.hpp"

namespace odomd::can {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;
constexpr std::int64_t ring_full_wait_ns = 2'000'000;
constexpr std::int64_t oldest_line_ns = 10 * ns_per_s;
constexpr std::int64_t long_pause_ns = 600 * ns_per_s;

std::int64_t time_on(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return now.tv_sec * ns_per_s + now.tv_nsec;
}

std::int64_t monotonic_now() noexcept {
  return time_on(CLOCK_MONOTONIC);
}

bool is_pipe(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode);
}

/// How long before its time the first frame is read. For a file it is the time that the reader
/// needs to run ahead; for a pipe, which may be live, it is short, since it adds latency.
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

LogFeeder::LogFeeder(std::string path, BusNames& buses, LogClock& clock)
    : path_(std::move(path)),
      label_(log_label(path_)),
      buses_(buses),
      clock_(clock),
      file_(open_log(path_, FifoOpening::at_once)),
      stop_(::eventfd(0, EFD_CLOEXEC)),
      pipe_(is_pipe(file_.get())),
      lead_ns_(head_start(pipe_, clock.period_ns())),
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
  std::size_t taken = 0;
  const Frame* frame = nullptr;
  const std::int64_t advance_ns = clock_.advance_ns();
  const auto released = [advance_ns](const Frame& f) {
    return f.time_ns == 0 ? 0 : f.time_ns - advance_ns;
  };
  while ((frame = ring_.front()) != nullptr && released(*frame) <= tick_ns) {
    if (taken == frames.size()) {
      counters_.carried_over.add();
      break;
    }
    if (frame->kind == FrameKind::error) {
      count_error_frame(*frame, counters_);
    } else {
      frames[count] = *frame;
      frames[count++].time_ns = released(*frame);
    }
    ring_.pop();
    ++taken;
  }
  counters_.received.add(count);
  return count;
}

LinkState LogFeeder::link() const noexcept {
  // In this order, because the last frames were pushed before the flag was set.
  return finished_.load(std::memory_order_acquire) && ring_.empty() ? LinkState::ended
                                                                    : LinkState::up;
}

// The thread's side -------------------------------------------------------------------------------

void LogFeeder::run() noexcept {
  try {
    feed();
  } catch (const std::exception& error) {
    warnings_.add(SourceWarning::failure, label_ + ": " + error.what());
  }
  finished_.store(true, std::memory_order_release);
}

void LogFeeder::feed() {
  while (std::optional<Frame> frame = next()) {
    check_stamps(*frame);
    if (frame->time_ns != 0) {
      follow_step(*frame);
      const std::int64_t base_ns = clock_.start(frame->time_ns, earliest_release(*frame));
      follow_arrivals(*frame);
      frame->time_ns -= base_ns;
      const std::int64_t release_ns = frame->time_ns - clock_.advance_ns();
      const std::int64_t pause_ns = release_ns - monotonic_now();
      if (pause_ns > long_pause_ns)
        warnings_.add(SourceWarning::long_pause,
                      at_line(label_, lines_.line_number()) + "the time stamps jump ahead by " +
                          std::to_string(pause_ns / ns_per_s) +
                          " s, and odomd waits that long; cut the log at the pause");
      // Runs ahead in steps of half the window, so that one wake-up reads many frames.
      if (pause_ns > reads_ahead_ns() &&
          wait_until(release_ns - reads_ahead_ns() / 2) == Waited::stopped)
        return;
    }
    while (!ring_.push(*frame))
      if (wait_until(monotonic_now() + ring_full_wait_ns) == Waited::stopped) return;
  }
  if (input_ended_ && !stamps_differ_ && with_only_stamp_ > 1) warn_of_one_stamp();
}

void LogFeeder::check_stamps(const Frame& frame) {
  if (stamps_differ_) return;
  stamps_differ_ = only_stamp_ns_.value_or(frame.time_ns) != frame.time_ns;
  only_stamp_ns_ = frame.time_ns;
  if (!stamps_differ_ && ++with_only_stamp_ == too_many_with_one_stamp) warn_of_one_stamp();
}

void LogFeeder::warn_of_one_stamp() {
  warnings_.add(SourceWarning::one_stamp, describe_one_stamp(at_line(label_, lines_.line_number()),
                                                             with_only_stamp_, *only_stamp_ns_));
}

/// Now plus the head start. The first line of a pipe may be older, because it was delayed or waited
/// in the pipe. If its stamp is from this machine's wall clock, its age is known.
std::int64_t LogFeeder::earliest_release(const Frame& first) const {
  const std::int64_t age_ns = pipe_ ? time_on(CLOCK_REALTIME) - first.time_ns : 0;
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
  warnings_.add(SourceWarning::clock_step, at_line(label_, lines_.line_number()) +
                                               "the clock of the time stamps was stepped by " +
                                               std::to_string(*step_ns / ns_per_s) +
                                               " s; following it from here on");
}

std::optional<Frame> LogFeeder::next() {
  Frame frame;
  while (!input_ended_) {
    if (const auto text = lines_.next_line()) {
      if (take(*text, frame)) return frame;
      continue;
    }
    if (wait_for_input() == Waited::stopped) return std::nullopt;
    switch (lines_.fill(file_.get())) {
      case LineBuffer::Fill::data:
      case LineBuffer::Fill::again:
        break;
      case LineBuffer::Fill::error:
        warnings_.add(SourceWarning::failure,
                      label_ + ": reading failed: " + std::generic_category().message(errno));
        [[fallthrough]];
      case LineBuffer::Fill::end:
        input_ended_ = true;
        if (const auto text = lines_.last_line(); text && take(*text, frame)) return frame;
    }
  }
  return std::nullopt;
}

bool LogFeeder::take(std::string_view text, Frame& frame) {
  if (is_blank(text)) return false;
  const CandumpLine line = parse_candump_line(text);
  if (!line.good()) {
    counters_.malformed.add();
    warnings_.add(SourceWarning::malformed_line,
                  input_ended_ ? describe_cut_off(label_, lines_.line_number())
                               : describe(label_, lines_.line_number(), line));
    return false;
  }
  if (line.interface != last_interface_) {
    const auto bus = buses_.index_of(line.interface);
    if (!bus) {
      counters_.malformed.add();
      warnings_.add(SourceWarning::too_many_buses,
                    describe_bus_too_many(label_, lines_.line_number(), line.interface));
      return false;
    }
    last_interface_ = line.interface;
    last_bus_ = *bus;
  }
  frame = line.frame;
  frame.bus = last_bus_;
  return true;
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
