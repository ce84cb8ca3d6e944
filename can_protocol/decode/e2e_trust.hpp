// Decides whether a protected message can be trusted: AUTOSAR's E2E state machine, with one window.
//
// An 8-bit CRC passes one random payload in 256, and the counter one in five of those. This is not
// enough against noise, a second sender or a wrong data id: on a full bus a payload passes several
// times a second. But then nearly all checks fail, so a message is not trusted after too many
// failed checks, nor is the first frame that passes right after an error.
#pragma once

#include <bit>
#include <cstdint>

#include "can_protocol/decode/e2e.hpp"

namespace odomd::can {

class E2eTrust {
 public:
  /// The number of remembered checks, and how many of them may fail. After a disturbance at most
  /// `window - max_failed` good frames are rejected; after a single error, one.
  static constexpr int window = 16;
  static constexpr int max_failed = 4;

  /// Records the result of a check and returns whether the message can be trusted. As in AUTOSAR,
  /// repeated and absent data count neither as passed nor as failed: gateways repeat frames.
  bool after(E2eStatus status) noexcept {
    const bool behind_error = after_error_;
    if (status != E2eStatus::repeated && status != E2eStatus::no_new_data) {
      const bool failed = status == E2eStatus::error || status == E2eStatus::wrong_sequence;
      failures_ = static_cast<std::uint16_t>(failures_ * 2U + (failed ? 1U : 0U));
      after_error_ = status == E2eStatus::error;
    }
    // Usually zero; std::popcount is a function call on CPUs without the instruction.
    const bool few = failures_ == 0 || std::popcount(failures_) <= max_failed;
    return few && !behind_error;
  }

 private:
  std::uint16_t failures_ = 0;  ///< the newest check is the lowest bit
  bool after_error_ = false;    ///< the newest check was an ERROR
};

}  // namespace odomd::can
