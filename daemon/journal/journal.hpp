// The daemon's log. Used by housekeeping only; the beat pushes events instead.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include <spdlog/logger.h>

#include "base/printable.hpp"
#include "daemon/core/config.hpp"

namespace odomd::daemon {

/// Frequent messages are limited to one per second and topic.
enum class Topic : std::uint8_t {
  overrun,
  missed,
  pose_reset,
  clock,
  frames_lost,
  bus_off,
  camera_connection,
  camera_refused,
  camera_malformed,
  recording,
  recording_end,
  count
};

class Journal {
 public:
  /// Throws std::invalid_argument where the file cannot be opened.
  explicit Journal(const LogConfig& config);

  void info(const std::string& text) { logger_->info("{}", one_line(text)); }
  void warn(const std::string& text) { logger_->warn("{}", one_line(text)); }
  void error(const std::string& text) { logger_->error("{}", one_line(text)); }

  /// As above, but logs at most one message per second and topic, with the number of suppressed
  /// ones.
  void info(Topic topic, std::int64_t now_ns, const std::string& text);
  void warn(Topic topic, std::int64_t now_ns, const std::string& text);

  /// Reopens the file after it was moved away. Keeps the old one when that fails.
  void reopen();

 private:
  void limited(spdlog::level::level_enum level, Topic topic, std::int64_t now_ns,
               const std::string& text);

  struct Limit {
    std::int64_t last_ns = 0;
    std::uint64_t kept_back = 0;
    bool ever = false;
  };

  LogConfig config_;
  std::shared_ptr<spdlog::logger> logger_;
  std::array<Limit, static_cast<std::size_t>(Topic::count)> limits_{};
};

}  // namespace odomd::daemon
