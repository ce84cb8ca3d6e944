#include "tools/init/traffic.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
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

can::SignalBinding binding_for(const Candidate& candidate, std::size_t channel) {
  can::SignalBinding binding;
  binding.channel = static_cast<std::uint16_t>(channel);
  binding.role = estimator::source_names.at(estimator::index_of(candidate.role));
  binding.message = candidate.message->name;
  binding.signals = {candidate.signal->name};
  if (candidate.fraction != nullptr) binding.signals.push_back(candidate.fraction->name);
  binding.unit = candidate.unit;
  binding.radius_m = 1.0;  // rpm: the angular velocity
  if (candidate.role == estimator::Source::direction) {
    binding.forward = candidate.forward;
    binding.reverse = candidate.reverse;
  }
  return binding;
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

std::vector<Series> series_of(const Traffic& traffic, std::span<const can::Database> databases,
                              std::span<const Candidate> candidates) {
  std::vector<Series> result(candidates.size());
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  // in groups, as a decoder takes no more signals of a message
  for (std::size_t from = 0; from < candidates.size(); from += can::max_samples_per_frame) {
    std::vector<can::SignalBinding> bindings;
    for (std::size_t i = from; i < std::min(candidates.size(), from + can::max_samples_per_frame);
         ++i)
      bindings.push_back(binding_for(candidates[i], i));
    can::Decoder decoder(databases, bindings, {}, traffic.buses);
    for (const can::Frame& frame : traffic.frames) {
      const can::DecodeResult decoded = decoder.decode(frame, samples);
      for (const can::Sample& sample : std::span(samples).first(decoded.count)) {
        Series& series = result[sample.channel];
        if (!std::isfinite(sample.value) ||
            (!series.empty() && sample.time_ns <= series.t_ns.back()))
          continue;
        series.t_ns.push_back(sample.time_ns);
        series.value.push_back(sample.value);
      }
    }
  }
  return result;
}

}  // namespace odomd::tools
