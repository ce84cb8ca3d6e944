#include "can_protocol/sources/log_stamps.hpp"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <utility>

#include "can_protocol/sources/log_lines.hpp"

namespace odomd::can {
namespace {

struct Spread {
  std::int64_t median_ns = 0;
  std::int64_t half_ns = 0;  ///< width of the middle half
};

Spread spread_of(std::vector<std::int64_t> stamps) {
  std::ranges::sort(stamps);
  const std::size_t n = stamps.size();
  return {stamps[n / 2], stamps[3 * n / 4] - stamps[n / 4]};
}

/// Whether this distance is too long for a stamp with all its neighbours before it, or all after.
bool is_far_from(std::int64_t distance_ns, const Spread& frames) {
  return distance_ns > std::max(LogStamps::max_behind_ns, 4 * frames.half_ns);
}

/// Whether the stamps are times since the previous frame: these are small and do not rise. Absolute
/// stamps rise, even with single stamps ahead or with several buses out of order.
bool are_deltas(std::span<const std::int64_t> stamps) {
  constexpr std::size_t fewest = 32;
  constexpr std::int64_t longest_usual_ns = 10'000'000'000;
  if (stamps.size() < fewest) return false;
  std::size_t falls = 0;
  std::size_t rises = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    falls += stamps[i] < stamps[i - 1] ? 1U : 0U;
    rises += stamps[i] > stamps[i - 1] ? 1U : 0U;
  }
  const auto early = stamps.first(stamps.size() / 2);
  const auto late = stamps.subspan(stamps.size() / 2);
  const std::int64_t usual_ns = spread_of({early.begin(), early.end()}).median_ns;
  const auto later = std::ranges::count_if(late, [=](std::int64_t ns) { return ns > usual_ns; });
  return usual_ns < longest_usual_ns && falls >= fewest / 4 && 2 * falls >= rises &&
         10 * static_cast<std::size_t>(later) < 8 * late.size();
}

}  // namespace

LogStamps::LogStamps(std::string label, Judging judging)
    : label_(std::move(label)), judging_(judging) {}

void LogStamps::add(const Frame& frame, std::uint64_t line_number) {
  ahead_.push_back({frame, line_number});
  if (++frames_ == with_one_stamp_ + 1 && (frames_ == 1 || frame.time_ns == last_stamp_ns_)) {
    ++with_one_stamp_;
  } else {
    with_one_stamp_ = 0;
  }
  last_stamp_ns_ = frame.time_ns;
  last_line_ = line_number;
  if (frames_ > enough_for_deltas) return;
  first_stamps_.push_back(frame.time_ns);
  if (frames_ == enough_for_deltas) refuse_deltas();
}

void LogStamps::end() {
  ended_ = true;
  if (frames_ < enough_for_deltas) refuse_deltas();
}

const LoggedFrame* LogStamps::next() {
  const std::size_t waits_for = judging_ == Judging::live || ended_ ? 1 : window + 1;
  while (ahead_.size() >= waits_for) {
    current_ = ahead_.front();
    ahead_.pop_front();
    const std::int64_t stamp_ns = current_.frame.time_ns;
    if (stamp_ns == 0 || judging_ == Judging::live) return &current_;
    if (stands_alone(stamp_ns)) {
      if (alone_++ == 0) first_alone_ = current_.line;
      continue;
    }
    before_.push_back(stamp_ns);
    if (before_.size() > window) before_.pop_front();
    return &current_;
  }
  return nullptr;
}

bool LogStamps::stands_alone(std::int64_t stamp_ns) const {
  if (!before_.empty() && stamp_ns >= before_.back() - max_behind_ns &&
      stamp_ns <= before_.back() + max_ahead_ns)
    return false;
  std::vector<std::int64_t> after;
  for (const LoggedFrame& frame : ahead_)
    if (frame.frame.time_ns != 0) after.push_back(frame.frame.time_ns);
  // After a pause, later frames have stamps close to this one.
  const auto has_company = [&] {
    return std::ranges::count_if(after, [=](std::int64_t ns) {
             return std::abs(ns - stamp_ns) <= max_ahead_ns;
           }) >= 2;
  };
  if (after.size() < window / 4) {  // the end of the log
    if (before_.size() < window) return false;
    const Spread earlier = spread_of({before_.begin(), before_.end()});
    if (is_far_from(std::abs(stamp_ns - earlier.median_ns), earlier)) return !has_company();
    if (after.empty()) return false;
  }
  const Spread later = spread_of(after);
  if (before_.empty())
    return stamp_ns > later.median_ns + max_ahead_ns ||
           (is_far_from(later.median_ns - stamp_ns, later) && !has_company());
  const auto [low, high] = std::minmax(before_.back(), later.median_ns);
  return stamp_ns < low - max_behind_ns || stamp_ns > high + max_ahead_ns;
}

void LogStamps::refuse_deltas() const {
  if (are_deltas(first_stamps_))
    throw LogError(label_ +
                   ": its stamps are the time since the frame before (candump -td); record the "
                   "time of each frame: candump -L, without -t");
}

std::string LogStamps::describe_one_stamp(std::uint64_t min_frames) const {
  if (with_one_stamp_ < min_frames) return {};
  const std::string s = std::to_string(last_stamp_ns_ / 1'000'000'000);
  const std::string us = std::to_string(1'000'000 + last_stamp_ns_ / 1000 % 1'000'000).substr(1);
  return at_line(label_, last_line_) + "all " + std::to_string(with_one_stamp_) +
         " frames so far have the time stamp " + s + "." + us +
         (last_stamp_ns_ == 0 ? ", which means no time" : "") +
         ": no time passes between them; record with candump -L, which stamps every frame";
}

std::string LogStamps::warning() const {
  if (alone_ == 0) return {};
  const std::string place = at_line(label_, first_alone_);
  return alone_ == 1
             ? place + "the stamp of this frame is far from those around it; the frame is left out"
             : place + "the stamps of " + std::to_string(alone_) +
                   " frames, from here on, are far from those around them; the frames are left out";
}

}  // namespace odomd::can
