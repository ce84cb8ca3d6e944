// The network for tests of the bridge, and the pace at which these tests tick.
#pragma once

#include <unistd.h>

#include <chrono>

#include "tests/tools/child.hpp"
#include "tests/tools/own_daemon.hpp"

namespace odomd::tools {

/// A DDS domain, and a network for $CYCLONEDDS_URI: only the loopback, without multicast, and with
/// a tag that separates it from other runs of these tests.
[[nodiscard]] inline std::uint32_t test_domain() {
  return 1 + static_cast<std::uint32_t>(::getpid()) % 90;
}
[[nodiscard]] inline std::string loopback_only() {
  return "<General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
         "<AllowMulticast>false</AllowMulticast></General>"
         "<Discovery><Tag>odomd-test-" +
         std::to_string(::getpid()) + '-' + std::to_string(now_ns()) +
         "</Tag><ParticipantIndex>auto</ParticipantIndex>"
         "<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>"
         "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>";
}

/// Pause between unanswered ticks: a delayed bridge sends these ticks together, and they must fit
/// into a socket's buffer.
inline constexpr std::chrono::milliseconds between_ticks{25};

}  // namespace odomd::tools
