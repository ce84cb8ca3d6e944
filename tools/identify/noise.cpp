// odom identify noise: what the sensors say while the car stands, and how well the filter's noise
// fits a drive.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "tools/identify/allan.hpp"
#include "tools/identify/delivery.hpp"
#include "tools/identify/driving_noise.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/process_noise.hpp"
#include "tools/identify/record.hpp"
#include "tools/identify/standing_noise.hpp"
#include "tools/identify/standstill.hpp"
#include "tools/text.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

struct Options {
  RecordOptions standing;
  std::string drive;
  std::string plot;
  bool no_camera = false;
  Delivery delivery;
};

struct Quantity {
  Source source;
  std::string unit;
  std::string walk_key;
};
const std::vector<Quantity>& inertial() {
  static const std::vector<Quantity> all{{Source::yaw_rate, "rad/s", "filter.gyro_bias_walk"},
                                         {Source::accel_x, "m/s2", "filter.accel_bias_walk"},
                                         {Source::accel_y, "m/s2", "filter.accel_bias_walk"}};
  return all;
}

std::string name_of(Source source) {
  return std::string(estimator::source_names[static_cast<std::size_t>(source)]);
}

std::string sigma_key(Source source) {
  return "can.signals." + name_of(source) + ".sigma";
}

bool is_configured(const std::optional<daemon::Config>& config, Source source) {
  return config && config->can.signals[static_cast<std::size_t>(source)].configured;
}

std::string curve_json_name(Source source) {
  return name_of(source);
}

/// The rows of one sensor at rest.
void add_standing(const Quantity& quantity, const StandingNoise& noise,
                  const std::vector<AllanPoint>& curve, const std::optional<daemon::Config>& config,
                  Findings& findings) {
  const std::string name = name_of(quantity.source);
  const auto add = [&](const std::string& what, const std::string& key, const Measured& measured,
                       const std::string& unit, const std::string& remark = "") {
    findings.values.push_back({.name = name + what,
                               .key = key,
                               .value = measured.value,
                               .sigma = measured.sigma,
                               .unit = unit,
                               .remark = remark});
  };
  const bool configured = is_configured(config, quantity.source);
  add(", noise", configured ? sigma_key(quantity.source) : "", noise.sigma, quantity.unit,
      noise.resolution_hides_noise
          ? fmt::format("of the steps of {:.3g}, which hide the sensor's own", noise.resolution)
          : "white, of a sample, at rest");
  add(", density", "", noise.density, quantity.unit + "/√Hz");
  add(", bias", "", noise.bias, quantity.unit, "at the begin of the record");
  Finding walk{.name = name + ", bias walk",
               .key = configured ? quantity.walk_key : "",
               .unit = quantity.unit + "/√s"};
  if (noise.walk) {
    walk.value = noise.walk->value;
    walk.sigma = noise.walk->sigma;
  } else {
    walk.determined = Determined::no;
    walk.remark = fmt::format("below {:.2g}: log longer to tell it", noise.walk_below);
  }
  findings.values.push_back(walk);
  const BiasInstability instability = bias_instability(curve);
  add(", bias instability", "", instability.value, quantity.unit,
      instability.reached
          ? fmt::format("at {:.3g} s", instability.tau)
          : fmt::format("at most: that the curve rises behind {:.3g} s is not certain; log longer",
                        instability.tau));
  if (noise.outliers > 0)
    findings.warnings.push_back(
        fmt::format("{}: {} lie 6 sigma off: was the car touched? Leave it alone, or cut with "
                    "--from, --to",
                    name, counted(static_cast<std::uint64_t>(noise.outliers), "sample")));
  for (const AllanPoint& point : curve)
    findings.details["allan"][curve_json_name(quantity.source)].push_back(
        {{"tau", point.tau}, {"deviation", point.deviation}, {"sigma", point.sigma}});
}

/// Of both accelerometers the larger walk: there is one key for them.
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

/// Errata, 9: of the paper's Q the variance of v_x, a step, must be more than what the acceleration
/// alone makes of it: Δt² σ²(a_x) where each step has a sample of its own, Δt S_a with S_a = σ² T
/// where it is held for T.
void add_papers_condition(const daemon::Config& config, const Measured& sigma, double sample_period,
                          Findings& findings) {
  const double step = 1e-9 * static_cast<double>(config.realtime.period_ns);
  const double held = std::max(sample_period, step);
  const double least = step * held * sigma.value * sigma.value;
  const double stated = config.paper_noise.Q[0];
  const bool holds = stated > least;
  findings.values.push_back({.name = "v_x, least variance a step",
                             .key = "",
                             .value = least,
                             .sigma = 2.0 * least * sigma.sigma / sigma.value,
                             .unit = "m2/s2",
                             .remark = fmt::format("the paper's condition {}: paper_q has {:.3g}",
                                                   holds ? "holds" : "is violated", stated)});
  findings.details["paper_condition"] = {
      {"least_variance_of_v_x", least}, {"paper_q_v_x", stated}, {"holds", holds}, {"step", step},
      {"accel_x_sigma", sigma.value},   {"accel_x_held", held}};
  if (!holds)
    findings.warnings.push_back(fmt::format(
        "[filter] paper_q gives v_x a variance of {:.3g} m2/s2 a step, less than the {:.3g} that "
        "the noise of accel_x alone makes in it: the model paper would trust the acceleration more "
        "than it deserves; make it larger",
        stated, least));
}

void identify_standing(const Options& options, const std::optional<daemon::Config>& config,
                       Findings& findings) {
  const std::string record = name_of(options.standing);
  const SignalLog log =
      read_record(options.standing, {Source::yaw_rate, Source::accel_x, Source::accel_y});
  findings.warnings.insert(findings.warnings.end(), log.warnings.begin(), log.warnings.end());
  check_that_wheels_stand(log, record);
  std::vector<AllanCurve> curves;
  for (const Quantity& quantity : inertial()) {
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
  if (curves.empty())
    throw std::invalid_argument(record +
                                ": no yaw_rate, accel_x or accel_y in it; map them in "
                                "[can.signals], or log the IMU");
  if (!has_wheels(log)) {
    check_that_imu_stands(log, curves, record);
    findings.warnings.push_back(record +
                                ": no wheel speed in it tells that the car stood; the IMU would "
                                "not see a slow straight roll");
  }
  settle_accel_walk(findings);
  if (!options.plot.empty()) chart::write_picture(options.plot, draw(curves));
}

void add_consistency(const char* when, const std::vector<SourceConsistency>& all,
                     Findings& findings) {
  for (const SourceConsistency& one : all)
    findings.details["nis"][when][name_of(one.source)] = {
        {"samples", one.samples}, {"mean", one.nis.value}, {"sigma", one.nis.sigma}};
}

// 0.5 to 2 is good enough; only about 1 is it what the filter expects.
std::string in_words(double nis) {
  if (nis > 2.0) return "surprises the filter: it trusts this source too much";
  if (nis > 1.25) return "bold: larger than the filter expects, by less than twice";
  if (nis >= 0.8) return "as the filter expects";
  if (nis >= 0.5) return "cautious: smaller than the filter expects, by less than twice";
  return "better than the filter thinks: it trusts this source too little";
}

void identify_driving(const Options& options, const std::optional<daemon::Config>& config,
                      Findings& findings) {
  Drive drive = read_drive({.folder = options.drive,
                            .config = options.standing.config,
                            .reference = {},
                            .camera = options.no_camera ? CameraUse::leave_out : CameraUse::take});
  findings.warnings.insert(findings.warnings.end(), drive.warnings.begin(), drive.warnings.end());
  std::vector<std::string> logs;
  for (const char* name : {"drive.log", "can.log"})
    if (logs.empty() && std::filesystem::exists(drive.folder / name))
      logs.push_back((drive.folder / name).string());
  const SignalLog log = read_signals(drive.config, logs);
  if (wheels_stand(log, 0.1))
    throw std::invalid_argument(drive.folder.string() +
                                ": no wheel turns faster than 0.1 m/s; --drive takes a drive, and "
                                "--config and --can a record of the standing car");
  const auto measure = [&](Source source, const std::string& unit) {
    const DrivingNoise noise = driving_noise(log.of(source));
    if (noise.samples == 0.0) return;
    const std::string key = sigma_key(source);
    Finding finding{.name = name_of(source) + ", noise on the move",
                    .key = is_configured(config, source) ? key : "",
                    .value = noise.sigma.value,
                    .sigma = noise.sigma.sigma,
                    .unit = unit,
                    .remark = "of a sample, the car's shaking with it"};
    if (!noise.smooth) {
      finding.determined = Determined::no;
      finding.remark = "the car moves as fast as samples come; faster samples, or a gentler drive";
    }
    findings.details["on_the_move"][name_of(source)] = {
        {"sigma", noise.sigma.value},
        {"white", noise.white.value},
        {"white_sigma", noise.white.sigma},
        {"increments", noise.increments.value},
        {"increments_sigma", noise.increments.sigma}};
    if (finding.determined == Determined::yes) {
      // What is larger while it drives is what a filter must know.
      for (Finding& at_rest : findings.values)
        if (at_rest.key == key) at_rest.key.clear();
      drive.config.can.signals[static_cast<std::size_t>(source)].sigma = noise.sigma.value;
    }
    findings.values.push_back(finding);
  };
  for (const Quantity& quantity : inertial()) measure(quantity.source, quantity.unit);
  for (const Source wheel : wheel_sources) measure(wheel, "m/s");

  const ProcessNoise process = process_noise(drive, drive.config);
  for (const SampleNoise& wheel : process.wheels) {
    const std::string key = sigma_key(wheel.source);
    for (Finding& other : findings.values)
      if (other.key == key) other.key.clear();
    findings.values.push_back({.name = name_of(wheel.source) + ", sigma for the filter",
                               .key = is_configured(config, wheel.source) ? key : "",
                               .value = wheel.sigma.value,
                               .sigma = wheel.sigma.sigma,
                               .unit = "m/s",
                               .remark = "by its innovations, slip with it"});
  }
  findings.values.push_back(process.yaw_moment);
  findings.values.push_back(process.tyre_force);
  add_consistency("before", process.before, findings);
  add_consistency("after", process.after, findings);
  for (const SourceConsistency& one : process.after)
    findings.values.push_back({.name = name_of(one.source) + ", mean NIS",
                               .value = one.nis.value,
                               .sigma = one.nis.sigma,
                               .remark = in_words(one.nis.value)});
}

void identify_noise(const Options& options) {
  const bool standing = is_given(options.standing);
  if (!standing && options.drive.empty())
    throw std::invalid_argument(
        "give a record of the standing car, --config and --can or --csv, a drive, --drive, or "
        "both; odom identify noise --help tells what each is for");
  if (!options.plot.empty()) {
    if (!standing) throw std::invalid_argument("--plot draws a standing record; give one");
    chart::check_picture_name(options.plot);
  }
  std::optional<daemon::Config> config;
  for (const std::string& file :
       {options.standing.config, options.delivery.write,
        options.drive.empty() ? std::string{} : options.drive + "/car.toml"})
    if (!config && !file.empty()) config = daemon::load_config(file);
  Findings findings{.method = "noise"};
  if (standing) {
    identify_standing(options, config, findings);
    findings.origin = "standing";
  }
  if (!options.drive.empty()) {
    identify_driving(options, config, findings);
    findings.origin += (standing ? " and " : "") + std::string("driving");
  }
  deliver(findings, options.delivery);
}

}  // namespace

void add_noise(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand(
      "noise", "The noise of gyro and accelerometers, and the filter's, from standing and driving");
  method.footer(
      "Standing: let the car stand where nothing shakes it, motor on, warm, and log its IMU for\n"
      "ten minutes; an hour tells the bias's walk, too. From it come the white noise of a sample\n"
      "and its density, bias, random walk and instability of the bias, by maximum likelihood and\n"
      "by the Allan deviation, which --plot draws. With --config the paper's condition is\n"
      "checked: the variance that the filter gives v_x in a step must exceed dt2 sigma2(a_x),\n"
      "or dt S where S is a density, or the filter trusts the accelerometer too much.\n"
      "\n"
      "Driving: a folder as odom sim and odom record leave it, with turns of all kinds, best\n"
      "with a camera. From it come the noise of each sensor on the move (R), which shaking makes\n"
      "larger than at rest, and the process noise (Q): so large that the innovations of the full\n"
      "filter are as large as it expects them, a mean NIS of 1. Parameters first: a wrong\n"
      "stiffness or latency looks like noise.\n"
      "\n"
      "Examples:\n"
      "  odom identify noise --config car.toml --can standing.log --plot allan.svg\n"
      "  odom identify noise --csv phone.csv --from 10 --to 600\n"
      "  odom identify noise --drive lap --write car.toml\n"
      "  odom identify noise --config car.toml --can standing.log --drive lap --write car.toml");
  const std::string standing = "Standing";
  add_record_options(method, options->standing, standing);
  method.add_option("--plot", options->plot, "Draw the Allan deviation, .svg or .png")
      .type_name("FILE")
      .group(standing);
  const std::string driving = "Driving";
  method
      .add_option("--drive", options->drive, "Folder of a drive, as odom sim and odom record make")
      .type_name("DIR")
      .group(driving);
  method.add_flag("--no-camera", options->no_camera, "Leave its camera poses out").group(driving);
  add_delivery(method, options->delivery);
  method.callback([options] { identify_noise(*options); });
}

}  // namespace odomd::tools
