#include "tools/identify/fit/findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/fit/window.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools::fitting {
namespace {

using estimator::Source;

/// The drive determines a value if its sigma is below this share of the prior's.
constexpr double reported_below = 0.5;

/// A value this many prior sigmas from the configured value is attributed to another cause, if
/// another parameter can compensate for it.
constexpr double astray_sigmas = 2.5;

/// The share of the grip that a drive must reach, so that the grip is not extrapolated.
constexpr double seen_at_least = 0.5;

struct Builder {
  const daemon::Config& config;
  const Settings& settings;
  const Result& result;
  Numbers<double> nominal;
  Numbers<double> sigma;  // including model errors
  Findings& findings;

  [[nodiscard]] double covariance(std::size_t a, std::size_t b) const {
    return result.covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  }

  [[nodiscard]] bool is_astray(Parameter k) const {
    return std::fabs(result.p[k]) > astray_sigmas * settings.prior_sigma[k];
  }

  [[nodiscard]] std::string sigmas_off(Parameter k) const {
    return fixed(std::fabs(result.p[k]) / settings.prior_sigma[k], 1);
  }

  /// Why the drive does not determine the parameter; empty if it does.
  [[nodiscard]] std::string why_not(Parameter k) const {
    if (!settings.free[k]) return "fixed";
    const std::optional<Parameter> other =
        twin(config.vehicle.wheelbase(), settings, result.turns.speed_variety, k);
    if (other && (is_astray(k) || is_astray(*other))) {
      const Parameter far = is_astray(k) ? k : *other;
      return "at one speed indistinguishable from " + meaning(*other) +
             (far == k ? ", and " : ", which came out ") + sigmas_off(far) +
             " sigmas from the configured value";
    }
    if (sigma[k] < reported_below * settings.prior_sigma[k]) return "";
    const ParameterInfo& info = parameter_table()[k];
    const auto two_sigma = [&info](double one) {
      return info.kind == ParameterKind::factor
                 ? fixed(200.0 * one, 1) + " %"
                 : fixed(2.0 * one, 4) + " " + std::string(info.unit);
    };
    std::string reason = "the drive adds little to what was known (2 sigma " + two_sigma(sigma[k]) +
                         ", before " + two_sigma(settings.prior_sigma[k]) + ")";
    const auto correlation = [&](const ParameterInfo& partner) {
      const Parameter j = partner.parameter;
      if (j == k || !settings.free[j]) return 0.0;
      return covariance(k, j) / std::sqrt(covariance(k, k) * covariance(j, j));
    };
    const ParameterInfo& strongest = *std::ranges::max_element(
        parameter_table(), {},
        [&](const auto& partner) { return std::fabs(correlation(partner)); });
    if (const double r = correlation(strongest); std::fabs(r) > 0.7)
      reason += "; correlated with " + std::string(strongest.name) + " (" + fixed(r, 2) + ")";
    return reason;
  }

  void add(Parameter k, std::string name, std::string key, const Measured& measured,
           std::string remark = "") {
    if (!settings.free[k]) return;
    Finding& finding = findings.add(std::move(name), std::move(key), measured,
                                    std::string(parameter_table()[k].unit), std::move(remark));
    if (std::string reason = why_not(k); !reason.empty()) finding.reject(std::move(reason));
  }

  [[nodiscard]] static std::string meaning(Parameter k) {
    return std::string(parameter_table()[k].meaning);
  }

  // Adds a value that the configuration uses directly.
  void add_value(Parameter k, const std::string& key) {
    const ParameterInfo& info = parameter_table()[k];
    const double value = value_of(info, nominal[k], result.p[k]);
    add(k, meaning(k), key,
        {value, info.kind == ParameterKind::factor ? value * sigma[k] : sigma[k]});
  }

  // measured = e^s true + b, so true = (measured - b) / e^s, in addition to the configured line.
  void add_line(Source source, Parameter scale, std::optional<Parameter> offset = {}) {
    const can::SignalBinding* binding = binding_of(config, source);
    if (binding == nullptr) return;
    const double factor = std::exp(-result.p[scale]), value = binding->scale * factor;
    add(scale, meaning(scale), key_of(source, ".scale"), {value, std::fabs(value) * sigma[scale]});
    if (offset)
      add(*offset, meaning(*offset), key_of(source, ".offset"),
          {(binding->offset - result.p[*offset]) * factor, sigma[*offset] * factor});
  }

  // Latencies are not negative: slightly negative ones become 0.
  void add_latency(Parameter k, Source source) {
    if (k == accel_latency && one_imu(config)) k = gyro_latency;
    if (binding_of(config, source) == nullptr) return;
    const std::string name = "latency of " + name_of(source), key = key_of(source, ".latency");
    const double measured = configured_latency(config, source) + result.p[k];
    std::string remark;
    if (measured < 0.0) remark = "measured " + fixed(1e3 * measured, 1) + " ms";
    if (!(measured < -2.0 * sigma[k])) {
      add(k, name, key, {std::max(0.0, measured), sigma[k]}, std::move(remark));
    } else if (settings.free[k]) {
      findings.add(name, key, {measured, sigma[k]}, "s")
          .reject(remark + ": are the poses' stamps late?");
    }
  }
};

struct AxleParameters {
  Axle axle;
  Parameter stiffness, bend;
  const char* end;  ///< how the axle's keys end: "front"
};

// If the drive shows that tyres saturate, the filter's brush tyre matches the fitted curve in the
// drive's hardest turns and at half of their acceleration. Otherwise the tyre is linear.
void add_tyres(Builder& b, const AxleParameters& a) {
  const std::string end = a.end;
  const std::string stiffness_key = "vehicle.cornering_stiffness_" + end;
  const auto brush_at = [&](const Numbers<double>& p) {
    Setup setup;
    setup.config = &b.config;
    setup.nominal = b.nominal;
    return brush_like(car_of(setup, p), a.axle, b.result.turns.hardest);
  };
  const std::optional<BrushTyre> brush = brush_at(b.result.p);
  std::string linear =
      b.why_not(a.stiffness).empty() ? b.why_not(a.bend) : "correlated with the stiffness";
  if (linear.empty() && !brush) linear = "nothing saturates";
  if (linear.empty() && b.result.turns.hardest < seen_at_least * brush->grip)
    linear = "the drive needs only " + fixed(b.result.turns.hardest, 1) + " m/s2 of about " +
             fixed(brush->grip, 0) + "; drive harder";
  if (!linear.empty()) {
    b.add_value(a.stiffness, stiffness_key);
    // An implausible curve results from another cause, which has changed its slope, too.
    if (b.settings.free[a.stiffness] && b.settings.free[a.bend] && b.is_astray(a.bend) &&
        b.findings.values.back().determined == Determined::yes) {
      b.findings.values.back().reject("correlated with " + Builder::meaning(a.bend) +
                                      ", which came out " + b.sigmas_off(a.bend) +
                                      " sigmas from the usual value");
    }
    if (b.settings.free[a.bend])
      b.findings.add("grip, " + end, "", {brush ? brush->grip : 0.0, 0.0}, "m/s2")
          .reject(linear + ": linear tyres");
    return;
  }
  // Σ' = J Σ Jᵀ, with J the derivatives of stiffness and grip with respect to the curve's
  // parameters.
  constexpr double h = 1e-3;
  const std::array<std::size_t, 3> curve{a.stiffness, a.bend, load_arm};
  Eigen::Matrix<double, 2, 3> jacobian;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    Numbers<double> p = b.result.p;
    p[curve.at(i)] += h;
    const BrushTyre moved = brush_at(p).value_or(*brush);
    jacobian.col(static_cast<Eigen::Index>(i)) << (moved.stiffness - brush->stiffness) / h,
        (moved.grip - brush->grip) / h;
  }
  const Eigen::Vector2d sigmas =
      (jacobian * b.result.covariance(curve, curve) * jacobian.transpose()).diagonal().cwiseSqrt();
  // The brush tyre's stiffness is no more precise than the fitted stiffness.
  b.add(a.stiffness, Builder::meaning(a.stiffness), stiffness_key,
        {brush->stiffness, std::max(sigmas[0], brush->stiffness * b.sigma[a.stiffness])},
        "of a tyre that saturates");
  b.findings.add("grip, " + end, "vehicle.grip_" + end, {brush->grip, sigmas[1]}, "m/s2");
}

// Delay and lag of an actuator, if the steering signal is a command.
void add_steering(Builder& b) {
  b.add_line(Source::steering, steering_scale, steering_offset);
  b.add_value(steering_delay, "");
  if (!b.settings.free[steering_delay] || !b.settings.free[steering_lag]) return;
  // The fitted parameters are the total delay and the logarithm of the lag: dτ = τ dp
  const double lag =
      value_of(parameter_table()[steering_lag], b.nominal[steering_lag], b.result.p[steering_lag]);
  const double whole = b.nominal[steering_delay] + b.result.p[steering_delay];
  const double of_whole = b.sigma[steering_delay], of_lag = lag * b.sigma[steering_lag];
  const double both = lag * b.covariance(steering_delay, steering_lag);
  SteeringResponse response;
  response.in_all = {whole, of_whole};
  response.time_constant = {lag, of_lag};
  response.dead_time = {
      whole - lag, std::sqrt(std::max(of_whole * of_whole + of_lag * of_lag - 2.0 * both, 0.0))};
  add_actuator(response, {}, b.config.vehicle.steering, b.findings);
}

void add_accelerometers(Builder& b) {
  const can::SignalBinding* x = binding_of(b.config, Source::accel_x);
  const can::SignalBinding* y = binding_of(b.config, Source::accel_y);
  b.add_latency(accel_latency, Source::accel_x);
  b.add_latency(accel_latency, Source::accel_y);
  // Offsets are the sensor's own, before the rotation by [imu] yaw: o = -R(-yaw) b
  const double c = std::cos(b.config.imu_yaw), s = std::sin(b.config.imu_yaw);
  const double bx = b.result.p[accel_bias_x], by = b.result.p[accel_bias_y];
  if (x != nullptr)
    b.add(accel_bias_x, Builder::meaning(accel_bias_x), "can.signals.accel_x.offset",
          {x->offset - (c * bx + s * by), b.sigma[accel_bias_x]});
  if (y != nullptr)
    b.add(accel_bias_y, Builder::meaning(accel_bias_y), "can.signals.accel_y.offset",
          {y->offset - (c * by - s * bx), b.sigma[accel_bias_y]});
  b.add_value(imu_x, "imu.position[0]");
  b.add_value(imu_y, "imu.position[1]");
  // The configuration rotates both axes together: they must have the same message and latency.
  const bool same_message =
      x != nullptr && y != nullptr && x->message == y->message && x->latency_ns == y->latency_ns;
  b.add_value(imu_yaw, same_message ? "imu.yaw" : "");
}

void add_wheels(Builder& b) {
  for (const Source source : wheel_sources) b.add_line(source, wheel_scale(source));
  for (const Source source : wheel_sources) b.add_latency(wheel_latency(source), source);
}

nlohmann::ordered_json details_of(const Builder& b) {
  nlohmann::ordered_json json;
  for (const ParameterInfo& info : parameter_table()) {
    const Parameter k = info.parameter;
    if (!b.settings.free[k]) continue;
    json["parameters"][std::string(info.name)] = {
        {"value", value_of(info, b.nominal[k], b.result.p[k])},
        {"relative_to_configured", b.result.p[k]},
        {"sigma", b.sigma[k]},
        {"sigma_if_independent", b.result.naive[k]},
        {"sigma_before", b.settings.prior_sigma[k]},
        {"determined", b.why_not(k).empty()}};
  }
  for (const SourceFit& source : b.result.sources)
    if (source.count > 0)
      json["residuals"][source.name] = {
          {"samples", source.count}, {"stated_sigma", source.stated}, {"sigma", source.found}};
  json["iterations"] = b.result.iterations;
  json["settled"] = b.result.settled;
  return json;
}

}  // namespace

Findings findings_of(const daemon::Config& config, std::span<const FitDrive> drives,
                     const Settings& settings, const Result& result) {
  Findings findings{.method = "fit"};
  double seconds = 0.0;
  for (const FitDrive& drive : drives) seconds += drive.end - drive.begin;
  findings.origin = fixed(seconds, 0) + " s of drive";

  Numbers<double> sigma = result.sigma;
  const Numbers<double> beyond =
      allowance(config.vehicle.wheelbase(), settings, result.turns.speed_variety);
  for (std::size_t k = 0; k < parameters; ++k)
    if (settings.free[k])  // adds model errors, but not beyond the prior
      sigma[k] =
          std::min(std::hypot(sigma[k], beyond[k]), std::max(sigma[k], settings.prior_sigma[k]));
  for (const Parameter k : {stiffness_front, stiffness_rear, yaw_inertia})
    if (settings.free[k]) sigma[k] = std::hypot(sigma[k], settings.mass_sigma);

  const Numbers<double> nominal = nominal_values(config);
  Builder b{config, settings, result, nominal, sigma, findings};
  add_tyres(b, {Axle::front, stiffness_front, bend_front, "front"});
  add_tyres(b, {Axle::rear, stiffness_rear, bend_rear, "rear"});
  b.add_value(yaw_inertia, "vehicle.yaw_inertia");
  b.add_value(track_width, "vehicle.track_width");
  add_steering(b);
  b.add_line(Source::yaw_rate, gyro_scale, gyro_bias);
  b.add_latency(gyro_latency, Source::yaw_rate);
  add_accelerometers(b);
  add_wheels(b);
  b.add_value(camera_x, "camera.lever_arm[0]");
  b.add_value(camera_y, "camera.lever_arm[1]");
  b.add_value(camera_yaw, "camera.lever_arm[2]");
  if (at_one_speed(config.vehicle.wheelbase(), settings, result.turns.speed_variety))
    add_warning(findings.warnings, kind("one_speed"), {},
                "the turns have much the same speed: softer front tyres with a larger steering "
                "scale fit equally well, as do softer rear tyres with a camera farther ahead");
  if (!kind("hard_turns").limits.hold(result.turns.hard))
    add_warning(
        findings.warnings, kind("hard_turns"), {},
        "{} % of the drive is above half of the grip (4.9 m/s2), where tyres are not linear: "
        "latencies of the wheels and stiffnesses may be off by more than stated",
        fixed(100.0 * result.turns.hard, 0));
  const auto before_the_poses = [](const Finding& finding) {
    return finding.name.starts_with("latency of ") && finding.value < 0.0;
  };
  const auto early = std::ranges::find_if(findings.values, before_the_poses);
  if (early != findings.values.end())
    add_warning(findings.warnings, kind("poses_stamped_late"), early->name,
                "came out {} ms before the poses: their stamps look late, and latencies and the "
                "steering's delay are off by as much",
                fixed(-1e3 * early->value, 0));
  if (!result.settled)
    add_warning(findings.warnings, kind("not_converged"), {}, "the fit did not converge");
  findings.details = details_of(b);
  findings.details["turns"] = {{"speed_variety", result.turns.speed_variety},
                               {"beyond_half_of_the_grip", result.turns.hard},
                               {"hardest", result.turns.hardest}};
  return findings;
}

}  // namespace odomd::tools::fitting
