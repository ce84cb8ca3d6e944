#include "tools/fault/stream_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace odomd::fault {
namespace {

using estimator::Source;

// Time between two frames that are output together.
constexpr std::int64_t frame_spacing_ns = 1000;

// Time constant of a wheel that spins up or locks.
constexpr double spinning_up_s = 0.15;

using Pair = std::pair<Source, Source>;
constexpr std::array front_and_rear{Pair{Source::wheel_front_left, Source::wheel_rear_left},
                                    Pair{Source::wheel_front_right, Source::wheel_rear_right}};
constexpr std::array x_and_y{Pair{Source::accel_x, Source::accel_y}};

/// The other source of the pair, or the source itself if it is in no pair.
Source exchanged(Source source, std::span<const Pair> pairs) {
  for (const auto& [first, second] : pairs) {
    if (source == first) return second;
    if (source == second) return first;
  }
  return source;
}

bool is_of_values(Act act) {
  return act <= Act::axes_swapped;
}

}  // namespace

FrameFault::FrameFault(const CarSignals& signals,
                       const std::array<double, estimator::source_count>& sigma, const Fault& fault,
                       ActiveTime span)
    : signals_(signals),
      fault_(fault),
      sources_(sources_of(fault.kind)),
      span_(span),
      random_(fault.seed, name_of(fault.kind)),
      sigma_(sigma),
      first_of_pair_(signals.message_count()),
      counters_(signals.message_count()),
      stamped_ns_(signals.message_count() + 1) {}

bool FrameFault::touches(std::optional<std::size_t> message) const {
  if (fault_.kind.part == Part::bus) return true;
  return message && signals_.carries(*message, sources_);
}

void FrameFault::take(const can::Frame& frame, std::vector<can::Frame>& out) {
  release(frame.time_ns, out);
  const Act act = fault_.kind.act;
  const std::optional<std::size_t> message = signals_.message_of(frame);
  if (message && is_of_values(act)) learn(*message, frame);
  const std::size_t before = out.size();
  if (!touches(message)) return out.push_back(frame);
  if (!span_.holds(frame.time_ns)) {
    keep_order(message, frame, out);
  } else {
    ++acted_on_;
    if (is_of_values(act)) {
      change_values(*message, out.emplace_back(frame));
    } else if (act == Act::bit_flips || act == Act::bit_flips_repaired) {
      flip(*message, out.emplace_back(frame));
    } else if (act == Act::duplicated) {
      renumbers_ = true;
      out.insert(out.end(), 2, frame);
      out.back().time_ns += frame_spacing_ns;
    } else if (act == Act::reordered) {
      renumbers_ = true;
      if (message) reorder(*message, frame, out);
      if (!message) out.push_back(frame);
    } else if (act != Act::lost) {
      stamp_anew(message, frame, out);
    }
  }
  if ((act == Act::duplicated || act == Act::reordered) && message)
    for (std::size_t i = before; i < out.size(); ++i) renumber(*message, out[i]);
}

void FrameFault::learn(std::size_t message, const can::Frame& frame) {
  const bool begun = span_.holds(frame.time_ns);
  const std::size_t count = signals_.read(message, frame, readings_);
  for (std::size_t i = 0; i < count; ++i) {
    Seen& seen = seen_[estimator::index_of(readings_[i].source)];
    if (begun && !seen.held) seen.held = seen.latest.value_or(readings_[i].value);
    seen.latest = readings_[i].value;
  }
}

void FrameFault::change_values(std::size_t message, can::Frame& frame) {
  can::E2eState own;
  const bool right = signals_.is_protected_right(message, frame, own);
  const std::size_t count = signals_.read(message, frame, readings_);
  for (std::size_t i = 0; i < count; ++i) {
    if (!contains(sources_, readings_[i].source)) continue;
    signals_.write(readings_[i].binding, changed(readings_[i], frame.time_ns), frame);
  }
  if (right) signals_.repair(message, frame, own);
}

std::optional<double> FrameFault::partner(Source source) const {
  std::span<const Pair> pairs = x_and_y;
  if (fault_.kind.act == Act::left_right) pairs = estimator::wheel_pairs;
  if (fault_.kind.act == Act::front_rear) pairs = front_and_rear;
  return seen_[estimator::index_of(exchanged(source, pairs))].latest;
}

double FrameFault::changed(const Reading& reading, std::int64_t time_ns) {
  const double value = reading.value;
  const double size = fault_.magnitude;
  const double t = static_cast<double>(time_ns - span_.begin_ns) * 1e-9;
  switch (fault_.kind.act) {
    case Act::frozen:
      return seen_[estimator::index_of(reading.source)].held.value_or(value);
    case Act::zero:
      return 0.0;
    case Act::stuck:
      return size;
    case Act::halved:
    case Act::doubled:
    case Act::scaled:
      return size * value;
    case Act::biased:
      return value + size;
    case Act::ramped:
      return value + size * t;
    case Act::inverted:
      return -value;
    case Act::noisy:
      return value + size * sigma_[estimator::index_of(reading.source)] * random_.normal();
    case Act::one_sided:
      return value < 0.0 ? size * value : value;
    case Act::rounded: {
      const double step = size * sigma_[estimator::index_of(reading.source)];
      return step > 0.0 ? step * std::round(value / step) : value;
    }
    case Act::slipping:
      return value * (1.0 + (size - 1.0) * -std::expm1(-t / spinning_up_s));
    case Act::locked:
      return value * std::exp(-t / spinning_up_s);
    case Act::left_right:
    case Act::front_rear:
    case Act::axes_swapped:
      return partner(reading.source).value_or(value);
    default:
      return value;
  }
}

void FrameFault::flip(std::size_t message, can::Frame& frame) {
  if (random_.uniform() >= fault_.magnitude) return;
  can::E2eState own;
  const bool right = signals_.is_protected_right(message, frame, own);
  const std::size_t count = signals_.read(message, frame, readings_);
  const std::span all(readings_.data(), count);
  const auto end = std::partition(all.begin(), all.end(), [&](const Reading& reading) {
    return contains(sources_, reading.source);
  });
  const auto candidates = static_cast<std::uint64_t>(end - all.begin());
  if (candidates == 0) return;
  const Reading& one = readings_[random_.bits() % candidates];
  signals_.flip_bit(one.binding, random_.bits(), frame);
  if (right && fault_.kind.act == Act::bit_flips_repaired) signals_.repair(message, frame, own);
}

bool FrameFault::keeps_order() const noexcept {
  return fault_.kind.act == Act::jittered || fault_.kind.act == Act::delayed;
}

// Frames of one message never overtake each other, whether queued or stamped late: neither during
// the fault nor at its end.
void FrameFault::keep_order(std::optional<std::size_t> message, const can::Frame& frame,
                            std::vector<can::Frame>& out) {
  const std::int64_t last_ns = stamped_ns_[message.value_or(signals_.message_count())];
  if (keeps_order() && last_ns >= frame.time_ns)
    return leave_at(frame.time_ns, message, frame, out);
  out.push_back(frame);
}

// Shifts the stamp by whole microseconds, the resolution of most logs.
void FrameFault::stamp_anew(std::optional<std::size_t> message, const can::Frame& frame,
                            std::vector<can::Frame>& out) {
  const double share = fault_.kind.act == Act::jittered ? random_.uniform(-1.0, 1.0) : 1.0;
  const std::int64_t shift_ns = std::llround(fault_.magnitude * share * 1e6) * 1000;
  leave_at(frame.time_ns + shift_ns, message, frame, out);
}

// A frame with a later stamp also arrives later; with an earlier stamp, its arrival is unchanged.
void FrameFault::leave_at(std::int64_t time_ns, std::optional<std::size_t> message,
                          const can::Frame& frame, std::vector<can::Frame>& out) {
  can::Frame stamped = frame;
  std::int64_t& last_ns = stamped_ns_[message.value_or(signals_.message_count())];
  stamped.time_ns = std::max(time_ns, frame_spacing_ns);
  if (keeps_order()) stamped.time_ns = std::max(stamped.time_ns, last_ns + frame_spacing_ns);
  last_ns = stamped.time_ns;
  if (stamped.time_ns <= frame.time_ns) return out.push_back(stamped);
  const auto place = std::ranges::upper_bound(held_, stamped.time_ns, {}, &can::Frame::time_ns);
  held_.insert(place, stamped);
}

void FrameFault::reorder(std::size_t message, const can::Frame& frame,
                         std::vector<can::Frame>& out) {
  auto& first = first_of_pair_[message];
  if (!first) {
    first = frame;
    return;
  }
  out.insert(out.end(), {frame, *first});
  out.back().time_ns = frame.time_ns + frame_spacing_ns;
  first.reset();
}

// Sets counters as the sender of the output frames would.
void FrameFault::renumber(std::size_t message, can::Frame& frame) {
  can::E2eState& last = counters_[message][frame.bus];
  can::E2eState own;
  if (!signals_.is_protected_right(message, frame, own)) return;
  if (renumbers_)
    signals_.protect(message, frame, last);
  else
    last = own;
}

void FrameFault::release(std::int64_t now_ns, std::vector<can::Frame>& out) {
  const auto due = std::ranges::upper_bound(held_, now_ns, {}, &can::Frame::time_ns);
  out.insert(out.end(), held_.begin(), due);
  held_.erase(held_.begin(), due);
  if (now_ns < span_.end_ns) return;
  for (std::size_t message = 0; message < first_of_pair_.size(); ++message) {
    auto& first = first_of_pair_[message];
    if (!first) continue;
    renumber(message, out.emplace_back(*first));
    first.reset();
  }
}

}  // namespace odomd::fault
