// The findings of a drive.
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/noise/driving_noise.hpp"
#include "tools/identify/noise/noise_findings.hpp"
#include "tools/identify/noise/process_noise.hpp"
#include "tools/identify/noise/standstill.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

void add_consistency(const char* when, const std::vector<SourceConsistency>& all,
                     Findings& findings) {
  for (const SourceConsistency& one : all)
    findings.details["nis"][when][name_of(one.source)] = {
        {"samples", one.samples}, {"mean", one.nis.value}, {"sigma", one.nis.sigma}};
}

// 0.5 to 2 is acceptable; about 1 is what the filter expects.
std::string in_words(double nis) {
  if (nis > 2.0) return "much larger than expected: the filter trusts this source too much";
  if (nis > 1.25) return "larger than expected, by a factor below 2";
  if (nis >= 0.8) return "as expected";
  if (nis >= 0.5) return "smaller than expected, by a factor below 2";
  return "much smaller than expected: the filter trusts this source too little";
}

}  // namespace

void add_driving_findings(const NoisyDrive& noisy, const std::optional<daemon::Config>& config,
                          Findings& findings) {
  Drive drive = read_drive(
      {.folder = noisy.folder, .config = noisy.config, .reference = {}, .camera = noisy.camera});
  append(findings.warnings, drive.warnings);
  const std::vector<std::string> logs{need_log_in(drive.folder).string()};
  const SignalLog log = read_signals(drive.config, logs);
  if (wheels_stand(log, 0.1))
    throw std::invalid_argument(drive.folder.string() +
                                ": no wheel turns faster than 0.1 m/s; --drive needs a moving car, "
                                "--config and --can a standing one");
  // Noise must not compensate for a wrong sign.
  check_agreement(drive.config, log, drive.cameras, {.drive = drive.folder.string()});
  const auto measure = [&](Source source, const std::string& unit) {
    const DrivingNoise noise = driving_noise(log.of(source));
    if (noise.samples == 0.0) return;
    const std::string key = sigma_key(source);
    Finding finding = as_finding(name_of(source) + ", noise on the move",
                                 is_configured(config, source) ? key : "", noise.sigma, unit,
                                 "of a sample, including the car's vibration");
    if (!noise.smooth)
      finding = undetermined(
          finding,
          "the car moves too fast for the sample rate; use faster samples, or a gentler drive");
    findings.details["on_the_move"][name_of(source)] = {
        {"sigma", noise.sigma.value},
        {"white", noise.white.value},
        {"white_sigma", noise.white.sigma},
        {"increments", noise.increments.value},
        {"increments_sigma", noise.increments.sigma}};
    if (finding.determined == Determined::yes) {
      // The filter needs the larger of the noises at rest and while driving.
      for (Finding& at_rest : findings.values)
        if (at_rest.key == key) at_rest.key.clear();
      drive.config.can.signals[static_cast<std::size_t>(source)].sigma = noise.sigma.value;
    }
    findings.values.push_back(finding);
  };
  for (const InertialSource& quantity : inertial_sources) measure(quantity.source, quantity.unit);
  for (const Source wheel : wheel_sources) measure(wheel, "m/s");

  ProgressLine progress("odom identify noise");
  const ProcessNoise process = process_noise(
      drive, drive.config, [&progress](const std::string& now) { progress.show(now); });
  progress.end();
  for (const SampleNoise& wheel : process.wheels) {
    const std::string key = sigma_key(wheel.source);
    for (Finding& other : findings.values)
      if (other.key == key) other.key.clear();
    findings.values.push_back(as_finding(name_of(wheel.source) + ", sigma for the filter",
                                         is_configured(config, wheel.source) ? key : "",
                                         wheel.sigma, "m/s", "by its innovations, including slip"));
  }
  findings.values.push_back(process.front_angle);
  findings.values.push_back(process.side_slip);
  add_consistency("before", process.before, findings);
  add_consistency("after", process.after, findings);
  for (const SourceConsistency& one : process.after)
    findings.values.push_back(
        as_finding(name_of(one.source) + ", mean NIS", "", one.nis, "", in_words(one.nis.value)));
}

}  // namespace odomd::tools
