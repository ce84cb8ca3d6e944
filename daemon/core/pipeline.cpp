#include "daemon/core/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/seconds.hpp"
#include "daemon/core/mounting.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::daemon {
namespace {

using estimator::Source;
using estimator::Verdict;

constexpr auto camera = static_cast<std::size_t>(Source::camera);

// How long the reset of a non-finite state is published, so that no reader misses it.
constexpr std::int64_t recovery_shown_ns = 1'000'000'000;

/// 95 % quantiles of χ² with 1, 2, 3 degrees of freedom.
constexpr std::array<double, 3> chi_squared_95{3.841458820694124, 5.991464547107979,
                                               7.814727903251179};

estimator::Filter initial_filter(const Config& config, bool camera_expected) {
  require_roles(config);
  estimator::FilterSettings settings = filter_settings(config);
  settings.initialise_from_camera = camera_expected && !config.initial_pose;
  estimator::Filter filter = estimator::make_filter(config.model, settings);
  if (!settings.initialise_from_camera)
    set_initial_pose(filter, config.initial_pose.value_or(estimator::Pose2{}));
  return filter;
}

bool failed_protection(can::FrameVerdict verdict) {
  return verdict == can::FrameVerdict::failed_crc || verdict == can::FrameVerdict::repeated ||
         verdict == can::FrameVerdict::wrong_sequence || verdict == can::FrameVerdict::distrusted;
}

}  // namespace

Pipeline::Pipeline(const Config& config, std::span<const can::Database> databases,
                   std::span<const std::string> bus_names, bool camera_expected)
    : decoder_(databases, config.can.bindings, config.can.protections, bus_names),
      camera_lever_arm_(config.camera.lever_arm),
      imu_yaw_(config.imu_yaw),
      state_{.filter = initial_filter(config, camera_expected), .wiring = Wiring(config.vehicle)} {
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    const SignalSettings& signal = config.can.signals[source];
    if (signal.configured) state_.watch.configure(source, signal.timeout_ns);
  }
  if (camera_expected)
    state_.watch.configure(camera, std::llround(estimator::camera_timeout_s * 1e9));
}

void Pipeline::take(const can::Frame& frame, std::int64_t now_ns) noexcept {
  if (frame.kind == can::FrameKind::error) return;
  state_.record.details.frames[frame.bus] += 1;

  const can::StampVerdict stamp = state_.stamp_guard.check(frame, now_ns);
  statistics_.stamps[static_cast<std::size_t>(stamp)].add();
  can::Frame timed = frame;
  if (stamp == can::StampVerdict::zero || stamp == can::StampVerdict::future)
    timed.time_ns = now_ns;

  // Decoded even if the stamp is bad: the protection's counter must see every frame.
  const can::DecodeResult result = decoder_.decode(timed, samples_);
  statistics_.frames[static_cast<std::size_t>(result.verdict)].add();
  if (result.message < 0) return;

  const can::BoundMessage& message = decoder_.messages()[static_cast<std::size_t>(result.message)];
  if (failed_protection(result.verdict)) {
    for (const std::uint16_t channel : message.channels) {
      count(channel, Verdict::failed_protection);
      state_.watch.failed(channel);
    }
    return;
  }
  for (std::size_t i = 0; i < message.channels.size(); ++i)
    if ((result.not_valid >> i & 1U) != 0) count(message.channels[i], Verdict::not_valid);
  take_samples({samples_.data(), result.count}, timed, stamp, now_ns);
}

void Pipeline::take_samples(std::span<can::Sample> samples, const can::Frame& frame,
                            can::StampVerdict stamp, std::int64_t now_ns) noexcept {
  if (imu_yaw_ != 0.0) turn_accelerations(samples, imu_yaw_);
  for (const can::Sample& sample : samples) {
    // A stamp that repeats or goes backwards comes from a faulty clock; such a sample has no valid
    // time.
    if (stamp == can::StampVerdict::repeated || stamp == can::StampVerdict::backwards) {
      count(sample.channel,
            stamp == can::StampVerdict::repeated ? Verdict::duplicate : Verdict::too_old);
      continue;
    }
    const estimator::Measurement measurement{.source = static_cast<Source>(sample.channel),
                                             .time_ns = sample.time_ns,
                                             .value = sample.value,
                                             .arrival_ns = now_ns};
    const std::optional<Verdict> verdict = add(state_.filter, measurement);
    if (verdict) count(sample.channel, *verdict);
    const auto refused = estimator::refusal(measurement);
    if (refused) {
      state_.watch.refused(sample.channel, *refused, now_ns);
    } else {
      state_.watch.usable(sample.channel);
    }
    // Wiring also needs samples that no car can produce: steering in degrees looks impossible.
    if (refused.value_or(Verdict::gated) == Verdict::gated)
      state_.wiring.add_sample(measurement.source, measurement.time_ns, measurement.value);
    if (verdict == Verdict::non_finite) continue;
    state_.watch.heard(sample.channel, frame.time_ns, sample.time_ns);
    statistics_.sources[sample.channel].last_time_ns.set(sample.time_ns);
  }
}

void Pipeline::take(const estimator::CameraPose& reference) noexcept {
  state_.record.details.camera_messages += 1;
  // Checked before the conversion, which would make a negative sigma positive.
  if (!estimator::is_usable(reference)) {
    state_.watch.unusable_pose();
    count(camera, Verdict::non_finite);
    return;
  }
  const estimator::CameraPose pose = to_centre_of_gravity(reference, camera_lever_arm_);
  state_.watch.usable_pose();
  const std::optional<Verdict> verdict = add(state_.filter, pose);
  if (verdict) judge_camera(*verdict);
  if (verdict == Verdict::non_finite) return;
  if (estimator::is_possible(estimator::Pose2{pose.x, pose.y, pose.yaw}))
    state_.wiring.add_pose(pose);
  state_.watch.heard(camera, reference.arrival_ns, reference.capture_ns);
  SourceStatistics& statistics = statistics_.sources[camera];
  statistics.last_time_ns.set(reference.capture_ns);
  statistics.last_latency_ns.set(reference.arrival_ns - reference.capture_ns);
}

void Pipeline::judge_camera(Verdict verdict, std::uint64_t samples) noexcept {
  count(camera, verdict, samples);
  if (verdict == Verdict::non_finite) return;
  state_.camera_rejected =
      verdict == Verdict::gated || verdict == Verdict::future || verdict == Verdict::too_old;
}

void Pipeline::take_malformed_camera_message() noexcept {
  state_.record.details.camera_messages += 1;
  statistics_.camera_malformed.add();
  state_.watch.unusable_pose();
}

void Pipeline::count(std::size_t source, Verdict verdict, std::uint64_t samples) noexcept {
  SourceStatistics& statistics = statistics_.sources[source];
  statistics.verdicts[static_cast<std::size_t>(verdict)].add(samples);
  statistics.last_verdict.set(static_cast<std::uint64_t>(verdict));
}

bool Pipeline::resume(const odom_pose& pose, const odom_details& details,
                      std::int64_t gap_ns) noexcept {
  return estimator::resume(state_.filter, to_estimate(pose, details), seconds(gap_ns));
}

estimator::SourceFlag Pipeline::flag_of(std::size_t source, std::int64_t tick_ns) const noexcept {
  using estimator::SourceFlag;
  if (state_.watch.failing(source)) return SourceFlag::failed_protection;
  if (state_.watch.overdue(source, tick_ns, state_.start_ns)) return SourceFlag::timed_out;
  const SourceFlag refused = state_.watch.flag(source);
  return refused != SourceFlag::ok ? refused : flag(state_.filter, static_cast<Source>(source));
}

std::uint32_t Pipeline::conditions(const estimator::Estimate& estimate,
                                   std::int64_t tick_ns) const noexcept {
  using estimator::SourceFlag;
  std::uint32_t bits = state_.outside_conditions | estimator_conditions(estimate);
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    const SourceFlag flagged = flag(state_.filter, static_cast<Source>(source));
    if (flagged == SourceFlag::slipping) {
      bits |= ODOM_COND_WHEEL_SLIP;
    } else if (flagged != SourceFlag::ok || state_.watch.flag(source) != SourceFlag::ok) {
      bits |= ODOM_COND_SENSOR_FAULT;
    }
    if (source != camera && state_.watch.overdue(source, tick_ns, state_.start_ns))
      bits |= ODOM_COND_SIGNAL_TIMEOUT;
    if (state_.watch.failing(source)) bits |= ODOM_COND_PROTECTION;
    if (state_.wiring.fault(source) != WiringFault::none) bits |= ODOM_COND_MISWIRED;
    if (state_.consistency[source].inconsistent()) bits |= ODOM_COND_INCONSISTENT;
  }
  if (state_.camera_rejected) bits |= ODOM_COND_CAMERA_REJECTED;
  if (state_.recovered_ns != 0 && tick_ns - state_.recovered_ns < recovery_shown_ns)
    bits |= ODOM_COND_NON_FINITE;
  return bits;
}

const TickRecord& Pipeline::tick(std::uint64_t number, std::int64_t tick_ns) noexcept {
  if (state_.start_ns == 0) state_.start_ns = tick_ns;

  const estimator::Estimate estimate = step(state_.filter, tick_ns);
  for (const estimator::Judgement& judgement : judgements()) {
    const auto source = static_cast<std::size_t>(judgement.source);
    InnovationStatistics innovations = statistics_.sources[source].innovations.get();
    innovations.take(judgement);
    statistics_.sources[source].innovations.set(innovations);
    state_.consistency[source].take(judgement);
    if (source == camera) {
      judge_camera(judgement.verdict, judgement.count);
    } else {
      count(source, judgement.verdict, judgement.count);
    }
  }
  statistics_.sources[camera].last_test_ratio.set(estimate.camera_test_ratio);

  if (estimate.recoveries != state_.recoveries) state_.recovered_ns = tick_ns;
  state_.recoveries = estimate.recoveries;

  state_.watch.settle(tick_ns);
  state_.wiring.update(tick_ns);
  const bool explained = state_.wiring.any_fault() || estimate.doubtful;
  for (Consistency& source : state_.consistency) source.update(tick_ns, explained);
  fill_record(estimate, state_.record);
  odom_pose& pose = state_.record.pose;
  pose.tick = number;
  pose.time_ns = tick_ns;
  pose.conditions = conditions(estimate, tick_ns);
  pose.mode = static_cast<std::uint32_t>(published_mode(estimate, pose.conditions));
  pose.health = 0;
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    state_.record.details.source_age_ns[source] = state_.watch.age_ns(source, tick_ns);
    const estimator::SourceFlag flag = flag_of(source, tick_ns);
    const WiringFault wiring = state_.wiring.fault(source);
    SourceStatistics& statistics = statistics_.sources[source];
    statistics.flag.set(static_cast<std::uint64_t>(flag));
    statistics.noise.set(noise(state_.filter, static_cast<Source>(source)));
    statistics.wiring.set(static_cast<std::uint64_t>(wiring));
    statistics.inconsistent.set(state_.consistency[source].inconsistent() ? 1U : 0U);
    if (state_.watch.healthy(source, tick_ns) && flag == estimator::SourceFlag::ok &&
        wiring == WiringFault::none)
      pose.health |= 1U << source;
  }
  return state_.record;
}

void Pipeline::restore(const PipelineState& state,
                       std::span<const can::ProtectionState> protections) noexcept {
  std::construct_at(&state_, state);  // in place, without a copy on the stack
  std::ranges::copy(protections, decoder_.protections().begin());
}

// Statistics

void InnovationStatistics::take(const estimator::Judgement& judgement) noexcept {
  if (judgement.degrees < 1 || judgement.degrees > 3) return;
  dimension = static_cast<std::uint64_t>(judgement.degrees);
  test_ratio = judgement.test_ratio;
  std::copy_n(judgement.innovation.begin(), dimension, innovation.begin());
  // A non-finite value would make the sum useless.
  if (!std::isfinite(judgement.squared_ratio)) return;
  nis_sum += judgement.squared_ratio;
  if (judgement.squared_ratio <= chi_squared_95[dimension - 1]) ++below_95;
  if (judgement.verdict == estimator::Verdict::gated) ++gated;
  ++count;
}

double InnovationStatistics::mean_nis() const noexcept {
  return count == 0 ? 0.0 : nis_sum / static_cast<double>(count);
}

double InnovationStatistics::inside_95() const noexcept {
  return count == 0 ? 0.0 : static_cast<double>(below_95) / static_cast<double>(count);
}

std::uint64_t SourceStatistics::judged() const noexcept {
  std::uint64_t sum = 0;
  for (const Counter& verdict : verdicts) sum += verdict.get();
  return sum;
}

}  // namespace odomd::daemon
