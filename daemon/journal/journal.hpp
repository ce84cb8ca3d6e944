// The daemon's log. Used by housekeeping only; the beat pushes events instead.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <spdlog/logger.h>

#include "base/printable.hpp"
#include "daemon/core/config.hpp"
#include "daemon/journal/repeats.hpp"

namespace odomd::daemon {

class Journal {
 public:
  /// Throws std::invalid_argument if the file cannot be opened.
  explicit Journal(const LogConfig& config);

  /// Logs the messages that were only counted. Not copyable.
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// A state that has changed, or an event that is rare: logged immediately.
  void info(const std::string& text) { write({spdlog::level::info, one_line(text)}); }
  void warn(const std::string& text) { write({spdlog::level::warn, one_line(text)}); }
  void error(const std::string& text) { write({spdlog::level::err, one_line(text)}); }

  /// An event that may come often: its repeats are counted and logged at growing intervals
  /// (repeats.hpp).
  void info_counted(const std::string& text) { count(spdlog::level::info, text); }
  void warn_counted(const std::string& text) { count(spdlog::level::warn, text); }

  /// Call in each turn of the loop: sets the time of the events that follow, and logs the counted
  /// messages that are due.
  void turn(std::int64_t now_ns);

  /// Reopens the file after it was moved away. Keeps the old file when that fails.
  void reopen();

 private:
  void count(spdlog::level::level_enum level, const std::string& text);
  /// Reports on standard error that the file cannot be written; counted repeats go to the file.
  void report_unwritten(const std::string& what);
  void write(const Message& message) { logger_->log(message.level, "{}", message.text); }

  LogConfig config_;
  std::shared_ptr<spdlog::logger> logger_;
  Repeats repeats_;
  std::int64_t now_ns_ = 0;  // time of the last call of turn()
};

}  // namespace odomd::daemon
