#include "daemon/check.hpp"

#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/sources/log_reader.hpp"
#include "can_protocol/sources/open_source.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::daemon {
namespace {

/// A time in nanoseconds as seconds, with six digits.
std::string seconds(std::int64_t ns) {
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

std::string access(std::uint32_t mode, const std::string& group) {
  return group.empty() ? fmt::format("mode {:04o}", mode)
                       : fmt::format("mode {:04o}, group {}", mode, group);
}

}  // namespace

std::string summary(const Config& config, std::span<const can::Database> databases,
                    const diagnostics::Diagnostics& warnings) {
  Lines lines;
  lines.title(config.file.string());
  lines.add("model", "{}, every {}", name_of(config.model), seconds(config.realtime.period_ns));
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
    lines.add("camera", "{} ({}), at most {} s old", config.camera.socket.string(),
              access(config.camera.socket_mode, config.camera.socket_group),
              config.camera.max_latency_s);
  lines.add("shared memory", "{} ({})", config.shm.name, access(config.shm.mode, config.shm.group));
  lines.add("status", "{} ({})", config.status.socket.string(),
            access(config.status.socket_mode, config.status.socket_group));
  lines.add("recorders", "{} ({})", record_socket(config).string(),
            access(record_mode(config), config.shm.group));
  lines.title("signals");
  for (const auto& binding : config.can.bindings) {
    const SignalSettings& settings = config.can.signals[binding.channel];
    lines.add(binding.role, "{}.{}, sigma {}, time-out {}", binding.message,
              fmt::join(binding.signals, " + "), settings.sigma, seconds(settings.timeout_ns));
  }
  if (!warnings.empty()) lines.title("warnings");
  std::string text = lines.text();
  for (const auto& warning : warnings) text += fmt::format("  {}\n", text_of(warning));
  return text;
}

}  // namespace odomd::daemon
