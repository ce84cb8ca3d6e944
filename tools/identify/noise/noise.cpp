// odom identify noise: noise, bias and bias walk of gyro and accelerometers on a standing car.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/inputs.hpp"
#include "tools/identify/noise/standing_noise.hpp"
#include "tools/math/median.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

struct Options {
  RecordOptions record;
  Delivery delivery;
};

/// A sensor of the IMU, and the largest values that it can have at rest on level ground.
struct Sensor {
  Source source;
  const char* unit;
  const char* walk_key;  ///< key of the walk of its bias
  double most_bias, most_noise;
  const char* other_units;  ///< what a larger value suggests
};

constexpr const char* accel_units =
    "is that the axis that points up, or in mg? Multiply these by 0.00980665";
constexpr std::array<Sensor, 3> sensors{{
    {Source::yaw_rate, "rad/s", "filter.gyro_bias_walk", 0.35, 0.2,
     "is that deg/s? Multiply by 0.0174533"},
    {Source::accel_x, "m/s2", "filter.accel_bias_walk", 5.0, 20.0, accel_units},
    {Source::accel_y, "m/s2", "filter.accel_bias_walk", 5.0, 20.0, accel_units},
}};

/// Adds the findings of one sensor. The keys are those of a configuration that maps it.
void add_sensor(const Sensor& sensor, const StandingNoise& noise,
                const std::optional<daemon::Config>& config, Findings& findings) {
  const std::string name = name_of(sensor.source), unit = sensor.unit;
  const bool mapped = config && is_mapped(*config, sensor.source);
  const auto add = [&](const std::string& what, const std::string& key, const Measured& measured,
                       const std::string& in, const std::string& remark = "") -> Finding& {
    return findings.add(name + what, mapped ? key : "", measured, in, remark);
  };
  add(", noise", key_of(sensor.source, ".sigma"), noise.sigma, unit,
      noise.resolution_hides_noise
          ? fmt::format("rounding noise of the resolution {:.3g}, which hides the sensor's noise",
                        noise.resolution)
      : noise.group_size > 1 ? fmt::format("at rest; about {} samples are correlated (filtered or "
                                           "held): chosen so that means over many samples get the "
                                           "right uncertainty",
                                           noise.group_size)
                             : "white noise of a sample at rest");
  // "multiplied by a factor of ten to compensate for additional uncertainties and vibrations"
  if (const double sigma = noise.sigma.value; sensor.source == Source::yaw_rate)
    add(", variance in the paper's R", "filter.paper_r[0]",
        {10.0 * sigma * sigma, 20.0 * sigma * noise.sigma.sigma}, "rad2/s2",
        fmt::format("ten times the gyro's, {:.3g}^2, as printed", sigma));
  add(", density", "", noise.density(), unit + "/√Hz");
  add(", bias", "", noise.bias, unit, "at the start of the record").share = Share::meaningless;
  Finding& walk =
      add(", bias walk", sensor.walk_key, noise.walk.value_or(Measured{}), unit + "/√s");
  if (!noise.walk)
    walk.reject(fmt::format("below {:.2g}: log longer to determine it", noise.walk_below));
  const auto outliers = static_cast<std::uint64_t>(noise.outliers);
  const bool one = outliers == 1;
  if (outliers > 0)
    add_warning(findings.warnings, kind("disturbed_record"), name, "{} {} 6 sigma off{}",
                counted(outliers, "sample"), one ? "lies" : "lie",
                !noise.outliers_left_out ? ""
                : one                    ? ", and is left out"
                                         : ", and are left out");
}

[[noreturn]] void refuse_moving(const SignalLog& log, const std::string& record,
                                const std::string& what, std::int64_t t_ns,
                                std::int64_t series_begin_ns) {
  const std::int64_t begin = log.first_ns != 0 ? log.first_ns : series_begin_ns;
  refuse("{}: the car moves: {} after {:.2f} s; log it at rest, or cut with --from and --to",
         record, what, 1e-9 * static_cast<double>(t_ns - begin));
}

/// Throws std::invalid_argument if the yaw rate leaves its median by 3 degrees a second although
/// the noise of a sample is much smaller.
void check_turning(const SignalLog& log, double white, const std::string& record) {
  constexpr double turning = 0.05;  // rad/s
  const Series& yaw_rate = log.of(Source::yaw_rate);
  const double median = median_of(yaw_rate.value);
  double squares = 0.0;
  for (const double value : yaw_rate.value) squares += (value - median) * (value - median);
  if (std::sqrt(squares / static_cast<double>(yaw_rate.size())) < 3.0 * white) return;
  for (std::size_t i = 0; i < yaw_rate.size(); ++i)
    if (const double off = yaw_rate.value[i] - median;
        std::fabs(off) >= std::max(turning, 6.0 * white))
      refuse_moving(log, record, fmt::format("yaw_rate is {:.2f} rad/s off its median", off),
                    yaw_rate.t_ns[i], yaw_rate.t_ns.front());
}

/// Returns whether wheels confirm that the car stands. Throws std::invalid_argument, with the time,
/// if one turns.
bool check_wheels(const SignalLog& log, const std::string& record) {
  bool any = false;
  for (const Source wheel : wheel_sources) {
    const Series& speed = log.of(wheel);
    any = any || !speed.empty();
    for (std::size_t i = 0; i < speed.size(); ++i)
      if (std::fabs(speed.value[i]) >= 0.05)
        refuse_moving(log, record, fmt::format("{} is {:.2f} m/s", name_of(wheel), speed.value[i]),
                      speed.t_ns[i], speed.t_ns.front());
  }
  return any;
}

/// The two accelerometers share one key for their bias walks: only the larger walk keeps it.
void settle_accel_walk(Findings& findings) {
  std::vector<Finding*> walks;
  for (Finding& finding : findings.values)
    if (finding.key == "filter.accel_bias_walk") walks.push_back(&finding);
  if (walks.size() < 2) return;
  const auto size = [](const Finding& walk) {
    return walk.determined == Determined::yes ? walk.value : -1.0;
  };
  (size(*walks[1]) > size(*walks[0]) ? walks[0] : walks[1])->key.clear();
}

Findings identify_noise(const Options& options) {
  if (!options.record.is_given())
    refuse(
        "give a record of the standing car, --config and --can or --csv; odom identify noise "
        "--help explains each");
  std::optional<daemon::Config> config;
  for (const std::string& file : {options.record.config, options.delivery.write})
    if (!config && !file.empty()) config = daemon::load_config(file);

  Findings findings{.method = "noise", .origin = "standing"};
  const std::string record = options.record.name();
  const SignalLog log =
      read_record(options.record, {Source::yaw_rate, Source::accel_x, Source::accel_y});
  append(findings.warnings, log.warnings);
  const bool has_wheels = check_wheels(log, record);
  bool any = false;
  for (const Sensor& sensor : sensors) {
    const Series& series = log.of(sensor.source);
    if (series.empty()) continue;
    const std::string name = record + ": " + name_of(sensor.source);
    const StandingNoise noise = standing_noise(series, name);
    if (sensor.source == Source::yaw_rate) check_turning(log, noise.prediction_error, record);
    if (std::fabs(noise.bias.value) >= sensor.most_bias || noise.sigma.value >= sensor.most_noise)
      refuse("{}: at rest it reads {:.3g} +- {:.3g} {}: {}", name, noise.bias.value,
             noise.sigma.value, sensor.unit, sensor.other_units);
    add_sensor(sensor, noise, config, findings);
    any = true;
  }
  if (!any) {
    for (const Sensor& sensor : sensors)
      if (!log.why_empty.at(estimator::index_of(sensor.source)).empty())
        (void)log.need(sensor.source);
    refuse(
        "{}: contains no yaw_rate, accel_x or accel_y; map them in [can.signals], or log the IMU",
        record);
  }
  if (!has_wheels)
    add_warning(findings.warnings, kind("standstill_unconfirmed"), record,
                "no wheel speed confirms that the car stood");
  settle_accel_walk(findings);
  return findings;
}

}  // namespace

void add_noise(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand(
      "noise", "Measure the noise of gyro and accelerometers of a stationary car");
  method.footer(
      R"(Park the warm car where nothing shakes it, with the motor on, and log its IMU for ten
minutes; an hour also shows the random walk of the bias. Maximum likelihood then gives the
white noise of a sample and its density, the bias, and its random walk. While the car
drives, the model full measures the noise itself.

Examples:
  odom identify noise --config car.toml --can standing.log
  odom identify noise --csv phone.csv --from 10 --to 600
  odom identify noise --config car.toml --can standing.log --write car.toml)");
  add_record_options(method, options->record);
  add_delivery(method, options, identify_noise);
  add_strict(method, options->record.damage);
}

}  // namespace odomd::tools
