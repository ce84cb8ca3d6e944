#include "tools/init/proposal.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/message_index.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "tools/cli/text.hpp"
#include "tools/live/listen.hpp"

namespace odomd::tools {
namespace {

Rhythm rhythm_of(const std::vector<const can::Frame*>& frames,
                 const std::vector<std::string>& buses) {
  Rhythm rhythm;
  std::map<std::size_t, std::size_t> count;  // of frames on each bus
  std::vector<std::int64_t> gaps;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ++count[frames[i]->bus];
    if (i > 0) gaps.push_back(frames[i]->time_ns - frames[i - 1]->time_ns);
  }
  if (!gaps.empty()) {
    std::ranges::sort(gaps);
    rhythm.cycle = 1e-9 * static_cast<double>(gaps[gaps.size() / 2]);
    rhythm.longest = 1e-9 * static_cast<double>(gaps[(gaps.size() - 1) * 999 / 1000]);
  }
  std::vector<std::pair<std::size_t, std::size_t>> busiest(count.begin(), count.end());
  std::ranges::stable_sort(busiest, std::ranges::greater{},
                           [](const auto& bus) { return bus.second; });
  for (const auto& [bus, frames_of_it] : busiest) rhythm.buses.push_back(buses.at(bus));
  return rhythm;
}

/// The binding as in the configuration.
can::SignalBinding binding_for(const Candidate& candidate) {
  can::SignalBinding binding;
  binding.role = name_of(candidate.role);
  binding.message = candidate.message->name;
  binding.signals = {candidate.signal->name};
  if (candidate.fraction != nullptr) binding.signals.push_back(candidate.fraction->name);
  for (const Companion& one : candidate.valid_when)
    binding.valid_when.push_back({one.signal->name, one.value.value()});
  if (candidate.sign) binding.sign = {candidate.sign->signal->name, *candidate.sign->value};
  binding.unless_raw = candidate.unless_raw;
  binding.unit = candidate.unit;
  binding.radius_m = 1.0;  // a speed in rpm becomes an angular velocity
  binding.forward = candidate.forward;
  binding.reverse = candidate.reverse;
  return binding;
}

double physical_in(const can::Signal& signal, const can::Frame& frame) {
  const can::SignalLayout layout = can::layout_of(signal);
  return can::physical_value(layout, can::extract_bits(layout, frame.data));
}

/// The frames with the signals of the candidate and its companions; their stamps rise.
std::vector<const can::Frame*> frames_of(const Candidate& candidate, const Traffic& traffic) {
  std::vector<const can::Signal*> read{candidate.signal};
  if (candidate.fraction != nullptr) read.push_back(candidate.fraction);
  for (const Companion& companion : candidate.valid_when) read.push_back(companion.signal);
  if (candidate.sign) read.push_back(candidate.sign->signal);
  const can::Message& message = *candidate.message;
  const auto key = can::frame_key(message.id, message.format);
  std::vector<const can::Frame*> frames;
  for (const can::Frame& frame : traffic.frames)
    if (can::frame_key(frame) == key &&
        (frames.empty() || frame.time_ns > frames.back()->time_ns) &&
        std::ranges::all_of(read, [&](const can::Signal* signal) {
          return frame.length >= can::layout_of(*signal).bytes_needed &&
                 can::is_present(message, *signal, frame.payload());
        }))
      frames.push_back(&frame);
  return frames;
}

}  // namespace

Traffic read_logs(std::span<const std::string> logs, can::Damage damage) {
  Traffic traffic;
  can::BusNames buses;
  can::MergedLog log(logs, buses, {}, damage);
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
    refuse("{}: no frame came in {:g} s; is the interface up and the car awake?", interface,
           seconds);
  return traffic;
}

std::map<std::uint32_t, Rhythm> rhythms(const Traffic& traffic,
                                        std::span<const can::Database> databases) {
  std::map<std::uint32_t, std::vector<const can::Frame*>> came;
  const can::MessageIndex index(databases);
  for (const can::Frame& frame : traffic.frames)
    if (const can::Message* message = index.find(frame))
      came[can::frame_key(message->id, message->format)].push_back(&frame);
  std::map<std::uint32_t, Rhythm> result;
  for (const auto& [key, frames] : came) result[key] = rhythm_of(frames, traffic.buses);
  return result;
}

Series series_of(const Traffic& traffic, std::span<const can::Database> databases,
                 Candidate& candidate) {
  const can::Signal& signal = *candidate.signal;
  const std::vector<const can::Frame*> frames = frames_of(candidate, traffic);
  for (Companion& companion : candidate.valid_when) {
    std::vector<double> seen;
    for (const can::Frame* frame : frames) seen.push_back(physical_in(*companion.signal, *frame));
    settle(companion, seen, candidate.warnings);
  }
  std::erase_if(candidate.valid_when, [](const Companion& one) { return !one.value; });
  constexpr int shortest = 8, longest = 52;  // bits
  const auto ones = static_cast<std::int64_t>(can::low_bits(signal.length));
  if (signal.type == can::ValueType::unsigned_integer && signal.length >= shortest &&
      signal.length < longest && std::ranges::any_of(frames, [&](const can::Frame* frame) {
        return can::extract_bits(can::layout_of(signal), frame->data) ==
               static_cast<std::uint64_t>(ones);
      })) {
    if (!candidate.unless_raw)
      candidate.unless_raw = {can::UnlessRaw::Pattern::all_ones, {}};
    else if (auto& raws = candidate.unless_raw->values; std::ranges::find(raws, ones) == raws.end())
      raws.push_back(ones);
  }
  // While it starts, a control unit may send the range's minimum or maximum; 0 counts as a value.
  const auto ready = std::ranges::find_if_not(frames, [&](const can::Frame* frame) {
    const double value = physical_in(signal, *frame);
    return signal.maximum > signal.minimum && value != 0.0 &&
           (value <= signal.minimum || value >= signal.maximum);
  });
  Series series;
  if (ready == frames.end()) return series;
  const std::array bindings{binding_for(candidate)};
  can::Decoder decoder(databases, bindings, {}, traffic.buses);
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  for (auto frame = ready; frame != frames.end(); ++frame) {
    if (decoder.decode(**frame, samples).count == 0 || !std::isfinite(samples[0].value)) continue;
    series.t_ns.push_back(samples[0].time_ns);
    series.value.push_back(samples[0].value);
  }
  return series;
}

}  // namespace odomd::tools
