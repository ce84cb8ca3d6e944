// The findings for a car at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/identify/noise/noise_findings.hpp"
#include "tools/identify/noise/standing_noise.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using diagnostics::found;
using tools::kind;

using estimator::Source;

/// Adds the findings of one sensor at rest.
void add_standing(const InertialSource& quantity, const StandingNoise& noise,
                  const std::vector<AllanPoint>& curve, const std::optional<daemon::Config>& config,
                  Findings& findings) {
  const std::string name = name_of(quantity.source);
  const auto add = [&](const std::string& what, const std::string& key, const Measured& measured,
                       const std::string& unit, const std::string& remark = "") -> Finding& {
    return findings.values.emplace_back(as_finding(name + what, key, measured, unit, remark));
  };
  add(", noise", key_if_mapped(config, quantity.source, key_of(quantity.source, ".sigma")),
      noise.sigma, quantity.unit,
      noise.resolution_hides_noise
          ? fmt::format("of the resolution of {:.3g}, which hides the sensor's own",
                        noise.resolution)
      : noise.together > 1 ? fmt::format("at rest; about {} samples are correlated, filtered or "
                                         "held: the value fits their means",
                                         noise.together)
                           : "white, of a sample, at rest");
  if (quantity.source == Source::yaw_rate) add_paper_variance(noise.sigma, config, findings);
  add(", density", "", noise.density, std::string(quantity.unit) + "/√Hz");
  add(", bias", "", noise.bias, quantity.unit, "at the start of the record").share =
      Share::meaningless;
  Finding& walk = add(", bias walk", key_if_mapped(config, quantity.source, quantity.walk_key),
                      noise.walk.value_or(Measured{}), std::string(quantity.unit) + "/√s");
  if (!noise.walk)
    walk = undetermined(walk, noise.jump ? "the level jumps: see the warning"
                                         : fmt::format("below {:.2g}: log longer to determine it",
                                                       noise.walk_below));
  const BiasInstability instability = bias_instability(curve);
  add(", bias instability", "", instability.value, quantity.unit,
      instability.reached
          ? fmt::format("at {:.3g} s", instability.tau)
          : fmt::format(
                "at most: whether the curve rises after {:.3g} s is not certain; log longer",
                instability.tau));
  if (noise.outliers > 0)
    findings.warnings.push_back(
        found(kind("disturbed_record"), name,
              counted(static_cast<std::uint64_t>(noise.outliers), "sample") +
                  (noise.outliers == 1 ? " lies 6 sigma off" : " lie 6 sigma off") +
                  (!noise.outliers_left_out ? ""
                   : noise.outliers == 1    ? ", and is left out"
                                            : ", and are left out")));
  if (noise.jump)
    findings.warnings.push_back(
        found(kind("disturbed_record"), name,
              fmt::format("jumps by {:.2g} {} after {:.1f} s", noise.jump->size, quantity.unit,
                          noise.jump->after)));
  for (const AllanPoint& point : curve)
    findings.details["allan"][name].push_back(
        {{"tau", point.tau}, {"deviation", point.deviation}, {"sigma", point.sigma}});
}

/// Refuses values that are impossible for a car on level ground: a record in other units, or of
/// another axis.
void refuse_other_units(const InertialSource& quantity, const StandingNoise& noise,
                        const std::string& name) {
  const bool turn = quantity.source == Source::yaw_rate;
  const double most_bias = turn ? 0.35 : 5.0, most_noise = turn ? 0.2 : 20.0;
  if (std::fabs(noise.bias.value) < most_bias && noise.sigma.value < most_noise) return;
  refuse("{}: at rest it reads {:.3g} +- {:.3g} {}: {}", name, noise.bias.value, noise.sigma.value,
         quantity.unit,
         turn ? "is that deg/s? Multiply by 0.0174533"
              : "is that the axis that points up, or in mg? Multiply these by 0.00980665");
}

constexpr double turning = 0.05;  // rad/s

double seconds_after(const SignalLog& log, const Series& series, std::size_t i) {
  const std::int64_t begin = log.first_ns != 0 ? log.first_ns : series.t_ns.front();
  return 1e-9 * static_cast<double>(series.t_ns[i] - begin);
}

void check_turning(const SignalLog& log, const Series& yaw_rate, double white,
                   const std::string& record) {
  const double median = median_of(yaw_rate.value);
  double squares = 0.0;
  for (const double value : yaw_rate.value) squares += (value - median) * (value - median);
  if (std::sqrt(squares / static_cast<double>(yaw_rate.size())) < 3.0 * white) return;
  for (std::size_t i = 0; i < yaw_rate.size(); ++i) {
    const double off = yaw_rate.value[i] - median;
    if (std::fabs(off) < std::max(turning, 6.0 * white)) continue;
    refuse(
        "{}: the car moves: yaw_rate is {:.2f} rad/s off its median after {:.2f} s; log it "
        "standing, or cut with --from and --to",
        record, off, seconds_after(log, yaw_rate, i));
  }
}

void check_curve(const AllanCurve& curve, const std::string& record) {
  const auto lowest = std::ranges::min_element(curve.points, {}, &AllanPoint::deviation);
  if (lowest == curve.points.end() || lowest->tau > 1.0) return;
  const auto highest = std::max_element(
      lowest, curve.points.end(),
      [](const AllanPoint& a, const AllanPoint& b) { return a.deviation < b.deviation; });
  if (highest->deviation - 2.0 * highest->sigma < 2.0 * lowest->deviation) return;
  refuse(
      "{}: the car moves: means of {} over {:.2g} s differ {:.1f} times as much as those over "
      "{:.2g} s, more than a bias can explain; log it standing, or cut with --from and --to",
      record, curve.name, highest->tau, highest->deviation / lowest->deviation, lowest->tau);
}

bool has_wheels(const SignalLog& log) {
  return std::ranges::any_of(wheel_sources, [&](Source wheel) { return !log.of(wheel).empty(); });
}

/// Throws std::invalid_argument, with the time, if a wheel turns.
void check_that_wheels_stand(const SignalLog& log, const std::string& record) {
  for (const Source wheel : wheel_sources) {
    const Series& speed = log.of(wheel);
    for (std::size_t i = 0; i < speed.size(); ++i) {
      if (std::fabs(speed.value[i]) < 0.05) continue;
      refuse(
          "{}: the car moves: {} is {:.2f} m/s after {:.2f} s; log it standing, or cut with --from "
          "and --to",
          record, estimator::source_names[static_cast<std::size_t>(wheel)], speed.value[i],
          seconds_after(log, speed, i));
    }
  }
}

/// Keeps the larger walk of the two accelerometers, which share a key.
void settle_accel_walk(Findings& findings) {
  Finding* kept = nullptr;
  for (Finding& finding : findings.values) {
    if (finding.key != "filter.accel_bias_walk") continue;
    const bool known = finding.determined == Determined::yes;
    if (kept != nullptr &&
        (!known || (kept->determined == Determined::yes && kept->value >= finding.value))) {
      finding.key.clear();
      continue;
    }
    if (kept != nullptr) kept->key.clear();
    kept = &finding;
  }
}

/// Errata, 9: in the paper's Q the variance of v_x per step must exceed the part that comes from
/// the acceleration's noise: Δt² σ²(a_x) if each step has its own sample, Δt S_a with S_a = σ² T if
/// a sample is held for T.
void add_papers_condition(const daemon::Config& config, const Measured& sigma, double sample_period,
                          Findings& findings) {
  const double step = 1e-9 * static_cast<double>(config.realtime.period_ns);
  const double held = std::max(sample_period, step);
  const double least = step * held * sigma.value * sigma.value;
  const double stated = config.paper_noise.Q[0];
  const bool holds = stated > least;
  findings.values.push_back(as_finding("v_x, least variance a step", "",
                                       {least, 2.0 * least * sigma.sigma / sigma.value}, "m2/s2",
                                       fmt::format("the paper's condition {}: paper_q has {:.3g}",
                                                   holds ? "holds" : "is violated", stated)));
  findings.details["paper_condition"] = {
      {"least_variance_of_v_x", least}, {"paper_q_v_x", stated}, {"holds", holds}, {"step", step},
      {"accel_x_sigma", sigma.value},   {"accel_x_held", held}};
  if (!holds)
    findings.warnings.push_back(found(
        kind("paper_noise_too_small"), "[filter] paper_q",
        fmt::format("gives v_x a variance of {:.3g} m2/s2 per step, less than the {:.3g} from "
                    "the noise of accel_x alone: the model paper would trust the acceleration "
                    "too much",
                    stated, least)));
}

}  // namespace

void add_paper_variance(const Measured& gyro_sigma, const std::optional<daemon::Config>& config,
                        Findings& findings) {
  const std::string key = "filter.paper_r[0]";
  for (Finding& earlier : findings.values)
    if (earlier.key == key) earlier.key.clear();
  const double sigma = gyro_sigma.value;
  findings.values.push_back(as_finding(
      "yaw_rate, variance in the paper's R", key_if_mapped(config, Source::yaw_rate, key),
      {10.0 * sigma * sigma, 20.0 * sigma * gyro_sigma.sigma}, "rad2/s2",
      fmt::format("ten times the gyro's, {:.3g}^2, as printed", sigma)));
}

bool wheels_stand(const SignalLog& log, double limit) {
  return std::ranges::all_of(wheel_sources, [&](Source wheel) {
    return std::ranges::all_of(log.of(wheel).value,
                               [&](double speed) { return std::fabs(speed) <= limit; });
  });
}

void check_that_imu_stands(const SignalLog& log, const std::vector<AllanCurve>& curves,
                           const std::string& record) {
  const Series& yaw_rate = log.of(Source::yaw_rate);
  for (const AllanCurve& curve : curves) {
    if (curve.name == "yaw_rate") check_turning(log, yaw_rate, curve.noise.from_the_last, record);
    if (!has_wheels(log)) check_curve(curve, record);
  }
}

void add_standing_findings(const RecordOptions& options, const std::string& plot,
                           const std::optional<daemon::Config>& config, Findings& findings) {
  const std::string record = name_of(options);
  const SignalLog log = read_record(options, {Source::yaw_rate, Source::accel_x, Source::accel_y});
  append(findings.warnings, log.warnings);
  check_that_wheels_stand(log, record);
  std::vector<AllanCurve> curves;
  for (const InertialSource& quantity : inertial_sources) {
    const Series& series = log.of(quantity.source);
    if (series.empty()) continue;
    const std::string name = record + ": " + name_of(quantity.source);
    const StandingNoise noise = standing_noise(series, name);
    curves.push_back(
        {name_of(quantity.source), quantity.unit, allan_deviation(series, name), noise});
    add_standing(quantity, noise, curves.back().points, config, findings);
    if (quantity.source == Source::accel_x && config)
      add_papers_condition(*config, noise.sigma, noise.sample_period, findings);
  }
  if (curves.empty()) {
    for (const InertialSource& quantity : inertial_sources)
      if (!log.why_empty.at(static_cast<std::size_t>(quantity.source)).empty())
        (void)log.need(quantity.source);
    refuse(
        "{}: contains no yaw_rate, accel_x or accel_y; map them in [can.signals], or log the IMU",
        record);
  }
  check_that_imu_stands(log, curves, record);
  for (const InertialSource& quantity : inertial_sources)
    for (const AllanCurve& curve : curves)
      if (curve.name == name_of(quantity.source))
        refuse_other_units(quantity, curve.noise, record + ": " + curve.name);
  if (!has_wheels(log)) {
    findings.warnings.push_back(found(kind("standstill_unconfirmed"), record,
                                      "no wheel speed confirms that the car stood"));
  }
  settle_accel_walk(findings);
  if (!plot.empty()) chart::write_picture(plot, draw(curves));
}

}  // namespace odomd::tools
