// Finds the messages of the log that repeat: the first is logged immediately, the next ones are
// counted and logged together at growing intervals. Pure logic on given times.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <spdlog/common.h>

namespace odomd::daemon {

struct Message {
  spdlog::level::level_enum level = spdlog::level::info;
  std::string text;
};

/// Two messages are the same when only their numbers differ: "ticks missed: 3" and "ticks missed:
/// 5", but not those about can0 and can1. For use by one thread.
class Repeats {
 public:
  /// The intervals at which a repeated message is logged: each is four times the one before. A
  /// message that is not repeated for the longest interval counts as new.
  static constexpr std::int64_t first_interval_ns = 1'000'000'000;
  static constexpr std::int64_t longest_interval_ns = 600'000'000'000;

  /// Whether to log a message now; otherwise it is counted.
  [[nodiscard]] bool take(const Message& message, std::int64_t now_ns);

  /// The counted messages whose interval is over: the newest text, with their number and duration.
  [[nodiscard]] std::vector<Message> due(std::int64_t now_ns);

  /// All counted messages, at the end.
  [[nodiscard]] std::vector<Message> rest(std::int64_t now_ns);

 private:
  struct Repetition {
    std::int64_t logged_ns = 0;
    std::int64_t interval_ns = first_interval_ns;
    std::uint64_t counted = 0;  ///< messages since the last logged one
    Message newest;             ///< the newest counted message
    std::int64_t newest_ns = 0;
  };

  static Message sum_of(Repetition& repetition, std::int64_t now_ns);

  std::map<std::string, Repetition> repetitions_;
};

}  // namespace odomd::daemon
