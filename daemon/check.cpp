// `odomd --check`: the configuration as odomd understands it, for a person to read before the car
// drives.
#include "daemon/run.hpp"

#include <algorithm>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/decode/units.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "can_protocol/sources/open_source.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::daemon {
namespace {

/// A time in nanoseconds as seconds, with six digits.
std::string duration(std::int64_t ns) {
  return fmt::format("{:.6g} s", static_cast<double>(ns) * 1e-9);
}

/// Builds lines of the form "  name  text".
class Lines {
 public:
  template <typename... Args>
  void add(std::string_view name, fmt::format_string<Args...> text, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), "  {:<18} ", name);
    fmt::format_to(std::back_inserter(text_), text, std::forward<Args>(args)...);
    text_ += '\n';
  }
  void title(std::string_view name) { text_ += fmt::format("{}\n", name); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string conversion(const can::SignalBinding& binding) {
  if (binding.forward)
    return fmt::format("forward = {}, reverse = {}", *binding.forward, *binding.reverse);
  auto text = fmt::format("in {}", can::unit_name(binding.unit));
  if (binding.radius_m > 0.0)
    text += fmt::format(", radius {} m, {}ratio {}", binding.radius_m,
                        binding.unit == can::Unit::erpm ? "pole pairs times " : "", binding.ratio);
  if (binding.scale != 1.0) text += fmt::format(", times {}", binding.scale);
  if (binding.offset != 0.0) text += fmt::format(", plus {}", binding.offset);
  return text;
}

/// "can0 (interface)". A log must exist; an interface may appear later.
std::string described(const std::string& source) {
  switch (can::source_kind(source)) {
    case can::SourceKind::standard_input:
      return "standard input";
    case can::SourceKind::log:
      static_cast<void>(can::open_log(source));
      return source + " (log)";
    case can::SourceKind::interface:
      return source + " (interface)";
  }
  return source;
}

/// In the order of can::Comparison.
constexpr std::array symbols{"=", "!=", "<", ">="};

/// In the order of can::UnlessRaw::Pattern.
constexpr std::array unavailable{"raw ", "the largest raw value", "all ones"};

/// "/odomd (mode 0640, group odom)"
std::string described(const SocketConfig& file) {
  return fmt::format("{} (mode {:04o}{}{})", file.path.string(), file.mode,
                     file.group.empty() ? "" : ", group ", file.group);
}

/// Describes a limit; 0 means that there is none.
std::string most(double limit, std::string_view unit) {
  return limit > 0.0 ? fmt::format("at most {} {}", limit, unit) : std::string("without limit");
}

std::string gradient(std::optional<double> configured) {
  return configured ? fmt::format("{} rad per g", *configured) : std::string("learnt");
}

void add_signals(Lines& lines, const Config& config) {
  lines.title("signals");
  for (const auto& binding : config.can.bindings) {
    const SignalSettings& settings = config.can.signals[binding.channel];
    std::string extra;
    if (!binding.bus.empty()) extra += fmt::format(", only on {}", binding.bus);
    if (binding.latency_ns != 0) extra += fmt::format(", latency {}", duration(binding.latency_ns));
    if (binding.source) extra += fmt::format(", only from {:#04x}", *binding.source);
    if (binding.sign)
      extra += fmt::format(", negative when {} = {}", binding.sign->signal, binding.sign->negative);
    for (const auto& condition : binding.valid_when)
      extra +=
          fmt::format(", valid when {} {} {}", condition.signal,
                      symbols.at(static_cast<std::size_t>(condition.comparison)), condition.value);
    if (const auto& unless = binding.unless_raw)
      extra += fmt::format(", not {}{}", unavailable.at(static_cast<std::size_t>(unless->pattern)),
                           fmt::join(unless->values, " "));
    if (settings.dead_band > 0.0) extra += fmt::format(", dead band {} m/s", settings.dead_band);
    lines.add(binding.role, "{}.{} {}, sigma {}, time-out {}{}", binding.message,
              fmt::join(binding.signals, " + "), conversion(binding), settings.sigma,
              duration(settings.timeout_ns), extra);
  }
}

}  // namespace

std::string summary(const Config& config, std::span<const can::Database> databases,
                    const diagnostics::Diagnostics& warnings) {
  Lines lines;
  const estimator::Vehicle& car = config.vehicle;
  lines.title(config.file.string());
  lines.add("vehicle",
            "{} kg, {} + {} m to the axles, {} kg m2, stiffness {} + {} N/rad, track {} m",
            car.mass, car.front_axle, car.rear_axle, car.yaw_inertia, car.cornering_stiffness_front,
            car.cornering_stiffness_rear, car.track_width);
  if (car.grip_front > 0.0 || car.grip_rear > 0.0)
    lines.add("grip", "front {}, rear {}", most(car.grip_front, "m/s2"),
              most(car.grip_rear, "m/s2"));
  if (const auto& servo = car.steering;
      servo.delay_s > 0.0 || servo.lag_s > 0.0 || servo.rate_limit > 0.0)
    lines.add("steering", "a command: {} s delay, {} s lag, rate {}", servo.delay_s, servo.lag_s,
              most(servo.rate_limit, "rad/s"));
  if (config.roll_gradient || config.pitch_gradient)
    lines.add("lean", "roll {}, pitch {}", gradient(config.roll_gradient),
              gradient(config.pitch_gradient));
  lines.add("model", "{}, every {}", name_of(config.model), duration(config.realtime.period_ns));
  lines.add("real time", "priority {}, {}", config.realtime.priority,
            config.realtime.cpu < 0 ? std::string("any CPU")
                                    : fmt::format("CPU {}", config.realtime.cpu));
  if (config.initial_pose) {
    lines.add("initial pose", "{}, {} m, {} rad", config.initial_pose->x, config.initial_pose->y,
              config.initial_pose->yaw);
  } else {
    lines.add("initial pose", "{}",
              config.camera.configured ? "the first camera pose" : "0, 0 m, 0 rad");
  }
  for (const auto& source : config.can.sources) lines.add("source", "{}", described(source));
  if (config.can.sources.empty()) lines.add("source", "none: give --can or [can] source");
  for (const auto& database : databases)
    lines.add("database", "{}: {} messages", database.file, database.messages.size());
  if (config.camera.configured)
    lines.add("camera", "{}, at most {} s old", described(config.camera.socket),
              config.camera.max_latency_s);
  lines.add("shared memory", "{}", described({config.shm.name, config.shm.mode, config.shm.group}));
  lines.add("status", "{}", described(config.status));
  lines.add("recorders", "{}", described(config.record));
  add_signals(lines, config);
  if (!config.can.protections.empty()) lines.title("protection");
  for (const auto& protection : config.can.protections)
    lines.add(protection.message, "{}",
              can::e2e_profile_names[static_cast<std::size_t>(protection.profile)]);
  if (!warnings.empty()) lines.title("warnings");
  std::string text = lines.text();
  for (const auto& warning : warnings) text += fmt::format("  {}\n", text_of(warning));
  return text;
}

}  // namespace odomd::daemon
