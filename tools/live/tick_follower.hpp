// Hands out every published tick, once and in order, through the client library; missed ticks are
// fetched from the history.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <odom/odom.hpp>
#include <optional>

namespace odomd::tools {

struct FollowCounts {
  std::uint64_t ticks = 0;        ///< handed out
  std::uint64_t fetched = 0;      ///< from the history, included in `ticks`
  std::uint64_t unpublished = 0;  ///< numbers that the daemon skipped
  std::uint64_t lost = 0;         ///< ticks that were no longer in the history
  std::uint64_t restarts = 0;     ///< times another daemon took over
};

/// For use by one thread. Survives restarts of the daemon.
class TickFollower {
 public:
  /// Starts after the current tick.
  explicit TickFollower(odom::Client client);

  /// Waits for new ticks and hands out each. ODOM_OK: something was handed out; other values give
  /// the reason (ODOM_TIMEOUT, ODOM_STALE, ...).
  odom_status follow(std::chrono::nanoseconds timeout,
                     const std::function<void(const odom_pose&)>& take);

  /// Whether the daemon has stopped publishing since the last call, from the result of follow().
  /// Throws std::runtime_error if no daemon can be followed any more.
  [[nodiscard]] bool falls_silent(odom_status status);
  [[nodiscard]] const FollowCounts& counts() const { return counts_; }
  [[nodiscard]] odom::Client& client() { return client_; }

 private:
  void catch_up(const odom_pose& newest, const odom_info& info, std::uint64_t first,
                const std::function<void(const odom_pose&)>& take);

  odom::Client client_;
  FollowCounts counts_;
  std::optional<odom_pose> last_;
  std::uint64_t instance_ = 0;
  bool silent_ = false;
};

}  // namespace odomd::tools
