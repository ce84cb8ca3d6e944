#include "tools/identify/common/signal_log.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "daemon/core/mounting.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/log_order.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/math/median.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

bool is_good(const can::Sample& sample, const Series& series) {
  return std::isfinite(sample.value) && (series.empty() || sample.time_ns > series.t_ns.back());
}

// Decodes a log frame by frame.
class SignalReader {
 public:
  SignalReader(const daemon::Config& config, std::span<const can::Database> databases,
               std::span<const std::string> buses)
      : decoder_(databases, config.can.bindings, config.can.protections, buses),
        imu_yaw_(config.imu_yaw) {}

  void take(const can::Frame& frame) {
    if (frames_++ == 0) log_.first_ns = frame.time_ns;
    log_.last_ns = std::max(log_.last_ns, frame.time_ns);
    const can::StampVerdict stamp = guard_.check(frame, frame.time_ns);
    const can::DecodeResult decoded = decoder_.decode(frame, samples_);
    const std::span<can::Sample> taken(samples_.data(), decoded.count);
    if (imu_yaw_ != 0.0) daemon::turn_accelerations(taken, imu_yaw_);
    for (const can::Sample& sample : taken) {
      Series& series = log_.signals[sample.channel];
      if (stamp != can::StampVerdict::trusted || !is_good(sample, series)) {
        ++left_out_;
        continue;
      }
      series.add(sample.time_ns, sample.value);
    }
  }

  SignalLog finished(std::string name) {
    log_.name = std::move(name);
    for (std::size_t i = 0; i < decoder_.messages().size(); ++i)
      if (const auto warning = check_message(decoder_.messages()[i], decoder_.counters(i)))
        for (const std::uint16_t channel : decoder_.messages()[i].channels)
          log_.why_empty.at(channel) = text_of(*warning);
    if (left_out_ > 0)
      add_warning(log_.warnings, diagnostics::kind("log_content"), log_.name,
                  "{} without a time of {} own, or not finite, left out",
                  counted(left_out_, "sample"), left_out_ == 1 ? "its" : "their");
    return std::move(log_);
  }

 private:
  can::Decoder decoder_;
  double imu_yaw_;
  can::StampGuard guard_;
  std::array<can::Sample, can::max_samples_per_frame> samples_{};
  std::uint64_t frames_ = 0;
  std::uint64_t left_out_ = 0;
  SignalLog log_;
};

}  // namespace

Series with_direction(Series speed, const Series& gear) {
  std::size_t g = 0;
  for (std::size_t i = 0; i < speed.size() && !gear.empty(); ++i) {
    while (g + 1 < gear.size() && gear.t_ns[g + 1] <= speed.t_ns[i]) ++g;
    if (gear.value[g] < 0.0) speed.value[i] = -std::fabs(speed.value[i]);
  }
  return speed;
}

double configured_latency(const daemon::Config& config, estimator::Source source) {
  const can::SignalBinding* binding = binding_of(config, source);
  return binding == nullptr ? 0.0 : 1e-9 * static_cast<double>(binding->latency_ns);
}

std::vector<PoseSample> in_order(std::span<const estimator::CameraPose> poses,
                                 std::int64_t origin_ns) {
  std::vector<estimator::CameraPose> seen(poses.begin(), poses.end());
  std::ranges::stable_sort(seen, {}, &estimator::CameraPose::capture_ns);
  std::vector<PoseSample> result;
  double yaw = seen.empty() ? 0.0 : seen.front().yaw;
  for (const estimator::CameraPose& pose : seen) {
    const double t = 1e-9 * static_cast<double>(pose.capture_ns - origin_ns);
    if (!result.empty() && t <= result.back().t) continue;
    yaw += std::remainder(pose.yaw - yaw, 2.0 * std::numbers::pi);
    result.push_back({t, pose.x, pose.y, yaw, pose.sigma_x, pose.sigma_y, pose.sigma_yaw});
  }
  return result;
}

const Series& SignalLog::need(estimator::Source source) const {
  const Series& series = of(source);
  if (has(source)) return series;
  const std::string& why = why_empty.at(estimator::index_of(source));
  refuse("{}: has {} {}: {}", name, series.empty() ? "no" : "a single sample of", name_of(source),
         !series.empty() ? "log it completely"
         : why.empty()   ? "it is mapped to no signal; map it in [can.signals]"
                         : why);
}

double white_sigma(std::span<const double> values) {
  std::vector<double> third;
  for (std::size_t i = 0; i + 3 < values.size(); ++i)
    third.push_back(values[i + 3] - 3.0 * values[i + 2] + 3.0 * values[i + 1] - values[i]);
  return robust_sigma(third) / std::sqrt(20.0);  // 1 + 9 + 9 + 1
}

SignalLog read_signals(daemon::Config config, std::span<const std::string> logs,
                       can::Damage damage) {
  diagnostics::Diagnostics warnings;
  const std::vector<can::Database> databases = daemon::load_databases(config, warnings);
  can::BusNames buses;
  can::MergedLog log = open_mapped_log(config, databases, logs, buses, damage);
  SignalReader reader(config, databases, buses.all());
  LogOrder order;
  while (const can::Frame* frame = log.next()) {
    order.take(frame->time_ns, [&log] { return log.position(); });
    reader.take(*frame);
  }
  order.require_sorted();
  append(warnings, diagnostics::kind("log_content"), log.warnings());
  SignalLog result = reader.finished(can::log_label(logs.front()));
  result.warnings.insert(result.warnings.begin(), warnings.begin(), warnings.end());
  return result;
}

SignalLog signals_of(const Drive& drive) {
  SignalReader reader(drive.config, drive.databases, drive.buses);
  for (const can::Frame& frame : drive.frames)
    if (frame.kind != can::FrameKind::error) reader.take(frame);
  return reader.finished(drive.name);
}

double Resampled::at(double t) const {
  const double place = std::clamp((t - begin) / step, 0.0, static_cast<double>(value.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(place), value.size() - 1);
  const std::size_t next = std::min(i + 1, value.size() - 1);
  return value[i] + (place - static_cast<double>(i)) * (value[next] - value[i]);
}

Resampled resampled(const Series& series, std::int64_t origin_ns, double begin, double end,
                    double step) {
  Resampled result{begin, step, {}};
  const auto count = static_cast<std::size_t>(std::max(1.0, std::floor((end - begin) / step) + 1));
  result.value.reserve(count);
  const auto time = [&](std::size_t k) {
    return 1e-9 * static_cast<double>(series.t_ns[k] - origin_ns);
  };
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = begin + step * static_cast<double>(i);
    while (k + 1 < series.size() && time(k + 1) <= t) ++k;
    double value = series.value[k];
    if (k + 1 < series.size() && t > time(k))
      value += (t - time(k)) / (time(k + 1) - time(k)) * (series.value[k + 1] - value);
    result.value.push_back(value);
  }
  return result;
}

Resampled integral(const Resampled& signal) {
  Resampled result = signal;
  double sum = 0.0;
  for (std::size_t i = 0; i < signal.value.size(); ++i) {
    if (i > 0) sum += 0.5 * signal.step * (signal.value[i - 1] + signal.value[i]);
    result.value[i] = sum;
  }
  return result;
}

Resampled slope_around(const Resampled& signal, double half) {
  return on_grid_of(signal, [&](double t) {
    const double from = std::max(t - half, signal.begin);
    const double to = std::min(t + half, signal.end());
    return to > from ? (signal.at(to) - signal.at(from)) / (to - from) : 0.0;
  });
}

Resampled mean_around(const Resampled& signal, double half) {
  return slope_around(integral(signal), half);
}

}  // namespace odomd::tools
