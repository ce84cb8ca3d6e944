// The daemon's log. Used by housekeeping only; the beat pushes events instead.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <spdlog/logger.h>

#include "daemon/core/config.hpp"
#include "daemon/journal/repeats.hpp"

namespace odomd::daemon {

class Journal {
 public:
  /// Throws std::invalid_argument where the file cannot be opened.
  explicit Journal(const LogConfig& config);

  /// A message that repeats is counted and logged at growing intervals (repeats.hpp), from the
  /// first turn() on: before, at the start, every message is logged.
  void info(const std::string& text) { log(spdlog::level::info, text); }
  void warn(const std::string& text) { log(spdlog::level::warn, text); }
  void error(const std::string& text) { log(spdlog::level::err, text); }

  /// Call every turn: sets the time of the messages that follow, and logs what was counted and is
  /// due.
  void turn(std::int64_t now_ns);
  /// Call when the daemon stops: logs all that was counted.
  void finish(std::int64_t now_ns);

  /// Reopens the file after it was moved away. Keeps the old one when that fails.
  void reopen();

 private:
  void log(spdlog::level::level_enum level, const std::string& text);
  void write(const Message& message) { logger_->log(message.level, "{}", message.text); }

  LogConfig config_;
  std::shared_ptr<spdlog::logger> logger_;
  Repeats repeats_;
  std::optional<std::int64_t> now_ns_;  // of the turn
};

}  // namespace odomd::daemon
