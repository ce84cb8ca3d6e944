#include "tools/identify/common/signal_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "daemon/core/imu_mounting.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/log_order.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

bool is_good(const can::Sample& sample, const Series& series) {
  return std::isfinite(sample.value) && (series.empty() || sample.time_ns > series.t_ns.back());
}

}  // namespace

const Series& SignalLog::need(estimator::Source source) const {
  const Series& series = of(source);
  if (series.size() > 1) return series;
  const auto index = static_cast<std::size_t>(source);
  const std::string& why = why_empty.at(index);
  throw std::invalid_argument(
      fmt::format("{}: has {} {}: {}", name, series.empty() ? "no" : "a single sample of",
                  estimator::source_names.at(index),
                  !series.empty() ? "log it completely"
                  : why.empty()   ? "it is mapped to no signal; map it in [can.signals]"
                                  : why));
}

SignalLog read_signals(daemon::Config config, std::span<const std::string> logs) {
  SignalLog result;
  const std::vector<can::Database> databases = daemon::load_databases(config, result.warnings);
  can::BusNames buses;
  for (const std::string& bus : daemon::expected_buses(config)) buses.index_of(bus);
  can::MergedLog log(logs, buses);
  can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses.all());

  LogOrder order;
  can::StampGuard guard;
  std::array<can::Sample, can::max_samples_per_frame> samples;
  std::uint64_t frames = 0;
  std::uint64_t left_out = 0;
  while (const can::Frame* frame = log.next()) {
    if (frame->kind == can::FrameKind::error) continue;
    order.take(frame->time_ns, [&log] { return log.position(); });
    if (frames++ == 0) result.first_ns = frame->time_ns;
    result.last_ns = std::max(result.last_ns, frame->time_ns);
    const can::StampVerdict stamp = guard.check(*frame, frame->time_ns);
    const can::DecodeResult decoded = decoder.decode(*frame, samples);
    const std::span<can::Sample> taken(samples.data(), decoded.count);
    if (config.imu_yaw != 0.0) daemon::turn_accelerations(taken, config.imu_yaw);
    for (const can::Sample& sample : taken) {
      Series& series = result.signals[sample.channel];
      if (stamp != can::StampVerdict::trusted || !is_good(sample, series)) {
        ++left_out;
        continue;
      }
      series.t_ns.push_back(sample.time_ns);
      series.value.push_back(sample.value);
    }
  }
  order.require_sorted();
  result.name = can::log_label(logs.front());
  for (std::size_t i = 0; i < decoder.messages().size(); ++i)
    if (const auto warning = check_message(decoder.messages()[i], decoder.counters(i)))
      for (const std::uint16_t channel : decoder.messages()[i].channels)
        result.why_empty.at(channel) = text_of(*warning);
  append(result.warnings, diagnostics::kind("log_content"), log.warnings());
  if (left_out > 0) {
    result.warnings.push_back(
        found(diagnostics::kind("log_content"), logs.front(),
              fmt::format("{} without a time of {} own, or not finite, left out",
                          counted(left_out, "sample"), left_out == 1 ? "its" : "their")));
  }
  return result;
}

}  // namespace odomd::tools
