#include "tools/init/traffic.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/message_index.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "tools/live/listen.hpp"

namespace odomd::tools {
namespace {

struct Arrivals {
  std::vector<std::int64_t> t_ns;
  std::array<std::uint64_t, can::max_buses> of_bus{};
};

Rhythm rhythm_of(Arrivals arrivals, const std::vector<std::string>& buses) {
  Rhythm rhythm;
  rhythm.frames = arrivals.t_ns.size();
  std::vector<std::int64_t> gaps;
  for (std::size_t i = 1; i < arrivals.t_ns.size(); ++i)
    gaps.push_back(arrivals.t_ns[i] - arrivals.t_ns[i - 1]);
  if (!gaps.empty()) {
    std::ranges::sort(gaps);
    rhythm.cycle = 1e-9 * static_cast<double>(gaps[gaps.size() / 2]);
    rhythm.longest = 1e-9 * static_cast<double>(gaps[(gaps.size() - 1) * 999 / 1000]);
  }
  std::vector<std::size_t> order;
  for (std::size_t bus = 0; bus < buses.size(); ++bus)
    if (arrivals.of_bus.at(bus) > 0) order.push_back(bus);
  std::ranges::sort(order, std::ranges::greater{},
                    [&](std::size_t bus) { return arrivals.of_bus.at(bus); });
  for (const std::size_t bus : order) rhythm.buses.push_back(buses[bus]);
  return rhythm;
}

/// believed() says which values at the ends of a range count.
void believe_ends(can::SignalBinding& binding, const can::Signal& signal) {
  if (signal.type == can::ValueType::unsigned_integer ||
      signal.type == can::ValueType::signed_integer)
    binding.unless_raw.emplace();
}

can::SignalBinding binding_for(const Candidate& candidate) {
  can::SignalBinding binding;
  binding.role = estimator::source_names.at(estimator::index_of(candidate.role));
  binding.message = candidate.message->name;
  binding.signals = {candidate.signal->name};
  if (candidate.fraction != nullptr) binding.signals.push_back(candidate.fraction->name);
  believe_ends(binding, *candidate.signal);
  binding.unit = candidate.unit;
  binding.radius_m = 1.0;  // rpm: the angular velocity
  if (candidate.role == estimator::Source::direction) {
    binding.forward = candidate.forward;
    binding.reverse = candidate.reverse;
  }
  return binding;
}

/// Of what was decoded (the value, its physical value, then the companions') the samples that the
/// candidate's own conditions accept, with their signs.
Series believed(Candidate& candidate, std::span<const Series> decoded) {
  const can::Signal& signal = *candidate.signal;
  const bool is_unsigned = signal.type == can::ValueType::unsigned_integer;
  constexpr int shortest = 8, longest = 52;  // bits
  const double all_ones = is_unsigned && signal.length >= shortest && signal.length < longest
                              ? std::ldexp(1.0, signal.length) - 1.0
                              : std::numeric_limits<double>::quiet_NaN();
  const auto holds = [&](const Companion& companion, std::size_t channel, std::size_t i) {
    return !companion.value || decoded[channel].value[i] == *companion.value;
  };
  Series series;
  bool starts = true;
  for (std::size_t i = 0; i < decoded[0].size(); ++i) {
    const double physical = decoded[1].value[i];
    const double raw = std::round((physical - signal.offset) / signal.scale);
    const bool at_the_end = signal.maximum > signal.minimum &&
                            (physical <= signal.minimum || physical >= signal.maximum);
    const bool is_out = raw == all_ones;
    candidate.all_ones = candidate.all_ones || is_out;
    bool good =
        std::isfinite(decoded[0].value[i]) && !is_out &&
        std::ranges::find(candidate.unless_raw, std::llround(raw)) == candidate.unless_raw.end();
    for (std::size_t k = 0; k < candidate.valid_when.size(); ++k)
      good = good && holds(candidate.valid_when[k], k + 2, i);
    starts = starts && at_the_end && physical != 0.0;
    if (!good || starts) continue;
    const bool negative = candidate.sign && holds(*candidate.sign, decoded.size() - 1, i);
    series.t_ns.push_back(decoded[0].t_ns[i]);
    series.value.push_back(negative ? -decoded[0].value[i] : decoded[0].value[i]);
  }
  return series;
}

}  // namespace

Traffic read_logs(std::span<const std::string> logs) {
  Traffic traffic;
  can::BusNames buses;
  can::MergedLog log(logs, buses);
  constexpr std::int64_t longest_pause_ns = 3'600'000'000'000;
  std::int64_t last_ns = 0;
  while (const can::Frame* frame = log.next()) {
    if (last_ns != 0 && std::abs(frame->time_ns - last_ns) > longest_pause_ns)
      throw std::invalid_argument(log.position() +
                                  "the log jumps by more than an hour; cut it there");
    last_ns = frame->time_ns;
    if (frame->kind == can::FrameKind::data) traffic.frames.push_back(*frame);
  }
  traffic.buses = buses.all();
  traffic.warnings = log.warnings();
  traffic.name = can::log_label(logs.front());
  return traffic;
}

Traffic listen(const std::string& interface, double seconds) {
  Traffic traffic;
  traffic.name = interface;
  can::BusNames buses;
  traffic.frames = listen({interface}, buses, daemon::CanConfig{}.receive_buffer,
                          std::chrono::duration<double>(seconds));
  std::erase_if(traffic.frames,
                [](const can::Frame& frame) { return frame.kind != can::FrameKind::data; });
  traffic.buses = buses.all();
  if (traffic.empty())
    throw std::invalid_argument(fmt::format(
        "{}: no frame came in {:g} s; is the interface up and the car awake?", interface, seconds));
  return traffic;
}

std::map<std::uint32_t, Rhythm> rhythms(const Traffic& traffic,
                                        std::span<const can::Database> databases) {
  std::map<std::uint32_t, Arrivals> arrivals;
  const can::MessageIndex index(databases);
  for (const can::Frame& frame : traffic.frames)
    if (const can::Message* message = index.find(frame)) {
      Arrivals& arrived = arrivals[can::frame_key(message->id, message->format)];
      arrived.t_ns.push_back(frame.time_ns);
      ++arrived.of_bus.at(frame.bus);
    }
  std::map<std::uint32_t, Rhythm> result;
  for (auto& [key, arrived] : arrivals) result[key] = rhythm_of(std::move(arrived), traffic.buses);
  return result;
}

Series series_of(const Traffic& traffic, std::span<const can::Database> databases,
                 Candidate& candidate) {
  const can::Signal& signal = *candidate.signal;
  std::vector<can::SignalBinding> bindings{binding_for(candidate)};
  const auto add_physical = [&](const can::Signal& of) {
    can::SignalBinding& binding = bindings.emplace_back();
    binding.channel = static_cast<std::uint16_t>(bindings.size() - 1);
    binding.role = binding.message = candidate.message->name;
    binding.signals = {of.name};
    believe_ends(binding, of);
  };
  add_physical(signal);
  for (const Companion& companion : candidate.valid_when) add_physical(*companion.signal);
  if (candidate.sign) add_physical(*candidate.sign->signal);
  std::vector<Series> all(bindings.size());
  can::Decoder decoder(databases, bindings, {}, traffic.buses);
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  const auto key = can::frame_key(candidate.message->id, candidate.message->format);
  for (const can::Frame& frame : traffic.frames) {
    if (can::frame_key(frame) != key || (!all[0].empty() && frame.time_ns <= all[0].t_ns.back()))
      continue;
    const can::DecodeResult decoded = decoder.decode(frame, samples);
    if (decoded.count != all.size()) continue;  // multiplexed, and not in this frame
    for (const can::Sample& sample : std::span(samples).first(decoded.count)) {
      all[sample.channel].t_ns.push_back(sample.time_ns);
      all[sample.channel].value.push_back(sample.value);
    }
  }
  for (std::size_t k = 0; k < candidate.valid_when.size(); ++k)
    settle(candidate.valid_when[k], all[k + 2].value, candidate.warnings);
  const Series series = believed(candidate, all);
  if (candidate.all_ones && !candidate.unless_raw.empty())
    candidate.unless_raw.push_back((std::int64_t{1} << candidate.signal->length) - 1);
  std::erase_if(candidate.valid_when, [](const Companion& one) { return !one.value; });
  return series;
}

}  // namespace odomd::tools
