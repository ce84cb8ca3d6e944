// The fit on a short simulated drive, and its errors for unsuitable ones.
#include "estimator/ekf/process_model.hpp"
#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/identify/fit/drive.hpp"
#include "tools/identify/fit/findings.hpp"
#include "tools/identify/fit/parameters.hpp"
#include "tools/identify/fit/solver.hpp"
#include "tools/identify/fit/window.hpp"

namespace odomd::tools::fitting::fit_test {
namespace {

using estimator::Source;
namespace st = car_model;

daemon::Config car() {
  daemon::Config config;
  config.file = "car.toml";
  for (const Source source : {Source::yaw_rate, Source::wheel_rear, Source::steering}) {
    auto& settings = config.can.signals[static_cast<std::size_t>(source)];
    settings.configured = true;
    settings.sigma = 0.005;
    can::SignalBinding binding;
    binding.channel = static_cast<std::uint16_t>(source);
    binding.role = std::string(estimator::source_names[static_cast<std::size_t>(source)]);
    config.can.bindings.push_back(binding);
  }
  return config;
}

car_model::Car<double> fitted_car(const Numbers<double>& p, const daemon::Config& config = car()) {
  Setup setup;
  setup.config = &config;
  setup.nominal = nominal_values(config);
  return car_of(setup, p);
}

Settings freeing(std::initializer_list<Parameter> parameters, double prior_sigma) {
  Settings settings;
  settings.mass_sigma = 0.0;
  for (const Parameter k : parameters) settings.free[k] = true;
  settings.prior_sigma.fill(prior_sigma);
  return settings;
}

/// A result in which every value is as configured.
Result unmoved(const Turns& turns = {}) {
  Result result;
  result.covariance.setZero(parameters, parameters);
  result.turns = turns;
  return result;
}

struct Recorded {
  SignalLog log;
  std::vector<estimator::CameraPose> poses;
};

struct Driving {
  double speed = 1.0;     // [m/s]
  double steering = 0.2;  // [rad]
};

// Twelve seconds of a car whose gyro reads 3 % too much, and whose wheels read 2 % too much.
Recorded recorded(const daemon::Config& config, const Driving& driving = {}) {
  const car_model::Car<double> model = fitted_car({}, config);
  constexpr std::int64_t start = 1'760'000'000'000'000'000;
  Recorded result;
  result.log.first_ns = start;
  const auto put = [&](Source source, std::int64_t t_ns, double value) {
    result.log.of(source).add(t_ns, value);
  };
  st::State<double> x{};
  x[st::v_x] = driving.speed;
  for (int k = 0; k < 12000; ++k) {
    const double t = 1e-3 * k;
    const std::int64_t t_ns = start + std::int64_t{1'000'000} * k;
    const double command = driving.steering * (std::sin(2.0 * t) + 0.5 * std::sin(4.7 * t));
    const double accel = 0.6 * std::cos(0.9 * t);
    if (k % 10 == 0) {
      put(Source::yaw_rate, t_ns, 1.03 * x[st::yaw_rate] + 0.01);
      put(Source::wheel_rear, t_ns, 1.02 * x[st::v_x]);
      put(Source::steering, t_ns, command + 0.004);
    }
    if (k % 35 == 0) {
      result.poses.push_back(
          {t_ns, t_ns, x[st::pos_x], x[st::pos_y], x[st::yaw], 0.005, 0.005, 0.005});
    }
    x = st::step(model, x, command, accel, accel, 1e-3);
  }
  result.log.last_ns = start + 12'000'000'000;
  return result;
}

const daemon::Config config = car();

TEST(Fit, RefusesMissingPosesAndPosesOfAnotherTime) {
  Recorded drive = recorded(config);
  EXPECT_THAT(message_of([&] { (void)prepare("lap", config, drive.log, {}); }),
              HasSubstr("lap: 0 poses"));
  for (estimator::CameraPose& pose : drive.poses) pose.capture_ns += 3'600'000'000'000;
  EXPECT_THAT(message_of([&] { (void)prepare("lap", config, drive.log, drive.poses); }),
              HasSubstr("overlap for 0.0 s"));
}

TEST(Fit, WidensUncertaintiesAtOneSpeed) {
  Settings settings;
  settings.free.fill(true);
  settings.prior_sigma.fill(0.3);
  const auto times = [&settings](Parameter k, double variety) {
    return allowance(0.26, settings, variety)[k] / allowance(0.26, settings, 0.46)[k];
  };
  EXPECT_EQ(times(steering_scale, 0.4), 1.0);
  EXPECT_EQ(times(steering_scale, 0.2), 4.0);
  EXPECT_DOUBLE_EQ(times(stiffness_rear, 0.0), 30.0);
  EXPECT_EQ(times(gyro_scale, 0.0), 1.0);
  EXPECT_TRUE(at_one_speed(0.26, settings, 0.1));
  EXPECT_FALSE(at_one_speed(0.26, settings, 0.4));
  settings.free[steering_scale] = false;
  EXPECT_EQ(times(stiffness_front, 0.0), 1.0);
  EXPECT_TRUE(at_one_speed(0.26, settings, 0.1));
  settings.prior_sigma[camera_x] = 1e-4;  // as good as fixed
  EXPECT_EQ(times(stiffness_rear, 0.0), 1.0);
  EXPECT_FALSE(at_one_speed(0.26, settings, 0.1));
}

TEST(Fit, RejectsLookAlikesIfOneIsFarFromItsConfiguredValue) {
  Settings settings = freeing({stiffness_rear, camera_x, gyro_scale}, 0.4);
  Result result = unmoved();
  const auto remarks = [&](double tyres, double variety) {
    result.p[stiffness_rear] = tyres;
    result.turns.speed_variety = variety;
    std::vector<std::string> reasons;
    for (const Finding& finding : findings_of(config, {}, settings, result).values)
      if (finding.determined == Determined::no) reasons.push_back(finding.remark);
    return reasons;
  };
  EXPECT_THAT(remarks(-0.9, 0.2), IsEmpty());
  EXPECT_THAT(remarks(-1.1, 0.4), IsEmpty());
  EXPECT_THAT(
      remarks(-1.1, 0.2),
      ElementsAre(
          "at one speed indistinguishable from camera's point ahead of the centre of gravity, "
          "and 2.8 sigmas from the configured value",
          "at one speed indistinguishable from cornering stiffness, rear, which came out 2.8 "
          "sigmas from the configured value"));
  settings.free[camera_x] = false;
  EXPECT_THAT(remarks(-1.1, 0.2), IsEmpty());
}

TEST(Fit, WarnsOfLatePosesIfASensorIsEarlierThanThem) {
  const Settings settings = freeing({gyro_latency}, 0.05);
  Result result = unmoved({.speed_variety = 0.5});
  result.settled = true;
  const auto warnings = [&](double latency) {
    result.p[gyro_latency] = latency;
    return findings_of(car(), {}, settings, result).warnings;
  };
  EXPECT_THAT(warnings(0.01), IsEmpty());
  EXPECT_THAT(warnings(-0.08),
              ElementsAre(diagnostics::Named("poses_stamped_late", "80 ms before the poses")));
}

TEST(Fit, FindsScalesAndOffsetsOfADriveFromItsOwnModel) {
  const Recorded drive = recorded(config);
  const std::vector<FitDrive> drives{prepare("lap", config, drive.log, drive.poses)};
  Settings settings;
  for (const Parameter k : {gyro_scale, gyro_bias, wheel_scale_rear, steering_offset})
    settings.free[k] = true;
  settings.prior_sigma = sigmas_of(&ParameterInfo::prior, config.vehicle.wheelbase());
  settings.passes = 2;
  const Result result = solve(config, drives, settings);
  EXPECT_NEAR(std::exp(result.p[gyro_scale]), 1.03, 3e-3);
  EXPECT_NEAR(result.p[gyro_bias], 0.01, 2e-3);
  EXPECT_NEAR(result.p[steering_offset], 0.004, 1e-3);
  // The fit assumes the usual slip of a driven wheel, which this drive lacks: hence the tolerance.
  EXPECT_NEAR(std::exp(result.p[wheel_scale_rear]), 1.02, 0.02);
  EXPECT_GT(result.sigma[gyro_scale], 0.0);
  EXPECT_LT(result.sigma[gyro_scale], 0.02);
  EXPECT_EQ(result.sigma[stiffness_front], 0.0);

  const Findings findings = findings_of(config, drives, settings, result);
  ASSERT_FALSE(findings.values.empty());
  const auto scale =
      std::ranges::find(findings.values, "can.signals.yaw_rate.scale", &Finding::key);
  ASSERT_NE(scale, findings.values.end());
  EXPECT_NEAR(scale->value, 1.0 / 1.03, 3e-3);
}

TEST(Fit, RefusesAFitWithoutParametersOrWindows) {
  const Recorded drive = recorded(config);
  const std::vector<FitDrive> drives{prepare("lap", config, drive.log, drive.poses)};
  Settings settings;
  EXPECT_THAT(message_of([&] { (void)solve(config, drives, settings); }), HasSubstr("--fix"));
  settings.free[gyro_scale] = true;
  settings.window = 7.0;
  EXPECT_THAT(message_of([&] { (void)solve(config, drives, settings); }),
              HasSubstr("nothing can be determined"));
}

// At 60 m/s the slip settles in 3 ms, a tenth of a full-size car's step.
TEST(Fit, FollowsTyresThatSettleWithinAStep) {
  daemon::Config full_size = car();
  full_size.vehicle = {.mass = 982.0,
                       .front_axle = 1.33,
                       .rear_axle = 1.07,
                       .yaw_inertia = 1605.0,
                       .cornering_stiffness_front = 90000.0,
                       .cornering_stiffness_rear = 120000.0,
                       .track_width = 1.35};
  const Recorded drive = recorded(full_size, {.speed = 60.0, .steering = 0.01});
  const std::vector<FitDrive> drives{prepare("straight", full_size, drive.log, drive.poses)};
  Settings settings;
  settings.free[gyro_scale] = true;
  settings.prior_sigma = sigmas_of(&ParameterInfo::prior, full_size.vehicle.wheelbase());
  settings.window = 1.5;
  settings.passes = 2;
  const Result result = solve(full_size, drives, settings);
  EXPECT_NEAR(std::exp(result.p[gyro_scale]), 1.03, 0.01);
  EXPECT_EQ(stable_parts(2.0, 0.044, 0.02), 1);  // slow cars need no smaller steps
  EXPECT_EQ(stable_parts(-60.0, 0.41, 0.03), 3);
}

Numbers<double> without_load_transfer() {
  Numbers<double> p{};
  p[load_arm] = -20.0;
  return p;
}

// Force of the filter's tyre model [N].
double force(const BrushTyre& tyre, double slip, double mass) {
  return slip *
         estimator::full::secant_stiffness(tyre.stiffness, slip, 1.0 / tyre.grip, mass).stiffness;
}

TEST(FitTyres, MatchTheFilterInTheHardestTurnsAndAtHalfTheirAcceleration) {
  const estimator::Vehicle v = car().vehicle;
  const double rear_mass = v.mass * v.front_axle / v.wheelbase();
  for (const Numbers<double>& p : {Numbers<double>{}, without_load_transfer()}) {
    const car_model::Car<double> fitted = fitted_car(p);
    const auto tyre = brush_like(fitted, Axle::rear, 8.0);
    ASSERT_TRUE(tyre);
    EXPECT_GT(tyre->grip, 8.0);
    for (const double accel : {4.0, 8.0})
      EXPECT_NEAR(force(*tyre, slip_at(fitted, Axle::rear, accel), rear_mass), rear_mass * accel,
                  1e-6 * rear_mass * accel);
  }
  // F = C α / √(1 + b s²) with s = C α / F_z; inverse: s = u / √(1 - b u²) with u = F / F_z
  const car_model::Car<double> fitted = fitted_car(without_load_transfer());
  const double u = 8.0 / st::gravity, load = rear_mass * st::gravity;
  EXPECT_NEAR(slip_at(fitted, Axle::rear, 8.0),
              u / std::sqrt(1.0 - fitted.bend_rear * u * u) * load / fitted.stiffness_rear, 1e-9);
}

TEST(FitTyres, AreNoBrushIfNothingSaturatesOrGripIsExceeded) {
  Numbers<double> p = without_load_transfer();
  EXPECT_FALSE(brush_like(fitted_car(p), Axle::front, 14.0));  // μ = 1.2 gives at most 11.7
  p[bend_front] = -30.0;
  EXPECT_FALSE(brush_like(fitted_car(p), Axle::front, 8.0));
}

// Findings for a car with usual tyres, depending on how hard it was driven.
std::vector<Finding> found_at(double hardest, double sigma_of_bend) {
  const Settings settings = freeing({stiffness_rear, bend_rear}, 0.5);
  Result result = unmoved({.speed_variety = 0.5, .hard = 0.0, .hardest = hardest});
  constexpr auto bend = static_cast<Eigen::Index>(bend_rear);
  result.covariance(bend, bend) = sigma_of_bend * sigma_of_bend;
  result.sigma[bend_rear] = sigma_of_bend;
  return findings_of(car(), {}, settings, result).values;
}

TEST(FitTyres, HaveAGripIfTheDriveShowsSaturation) {
  const std::vector<Finding> hard = found_at(9.0, 0.1);
  ASSERT_EQ(hard.size(), 2U);
  EXPECT_EQ(hard[0].key, "vehicle.cornering_stiffness_rear");
  EXPECT_GT(hard[0].value, car().vehicle.cornering_stiffness_rear);  // brush curves bend from 0
  EXPECT_EQ(hard[1].key, "vehicle.grip_rear");
  EXPECT_EQ(hard[1].determined, Determined::yes);
  EXPECT_NEAR(hard[1].value, 12.0, 3.0);
  EXPECT_GT(hard[1].sigma, 0.0);
  const auto linear = [](const std::vector<Finding>& found, const char* why) {
    EXPECT_EQ(found[0].value, car().vehicle.cornering_stiffness_rear);
    EXPECT_EQ(found[1].determined, Determined::no);
    EXPECT_EQ(found[1].key, "");
    EXPECT_THAT(found[1].remark, HasSubstr(why));
  };
  linear(found_at(4.0, 0.1), "the drive needs only 4.0 m/s2");
  linear(found_at(9.0, 0.4), "adds little");
}

TEST(FitTyres, AreRejectedIfTheirCurveIsImpossible) {
  const Settings settings = freeing({stiffness_front, bend_front}, 0.5);
  Result result = unmoved({.speed_variety = 0.5, .hard = 0.0, .hardest = 9.0});
  const auto stiffness = [&](double bend) {
    result.p[bend_front] = bend;
    return findings_of(car(), {}, settings, result).values.at(0);
  };
  EXPECT_EQ(stiffness(-0.2).determined, Determined::yes);
  EXPECT_EQ(stiffness(-2.4).determined, Determined::no);
  EXPECT_THAT(stiffness(-2.4).remark, HasSubstr("came out 4.8 sigmas from the usual value"));
}

TEST(FitSteering, IsAnActuatorIfDelayAndLagAreVisible) {
  const Settings settings = freeing({steering_delay, steering_lag}, 0.8);
  Result result = unmoved();
  const auto keys = [&](double whole) {
    result.p[steering_delay] = whole - 0.05;
    std::vector<std::string> written;
    for (const Finding& finding : findings_of(config, {}, settings, result).values)
      if (finding.determined == Determined::yes && !finding.key.empty())
        written.push_back(finding.key);
    return written;
  };
  EXPECT_THAT(keys(0.16), ElementsAre("steering.delay", "steering.lag"));
  EXPECT_THAT(keys(0.003), IsEmpty());  // a measured angle
}

}  // namespace
}  // namespace odomd::tools::fitting::fit_test
