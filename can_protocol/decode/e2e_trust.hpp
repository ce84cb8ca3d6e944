// Whether a protected message may be believed at all: AUTOSAR's E2E state machine, with one window.
//
// A CRC of 8 bits lets one random payload of 256 pass, and a counter one of five of those. Against
// noise, a second sender or a wrong data id that is not enough: at a full bus something passes
// every few milliseconds. But then nearly all checks fail: a message whose checks fail is not
// believed where one happens not to, nor is the first that passes right behind an error.
#pragma once

#include <bit>
#include <cstdint>

#include "can_protocol/decode/e2e.hpp"

namespace odomd::can {

class E2eTrust {
 public:
  /// Checks that are remembered, and how many of them may have failed. A disturbance that ends
  /// costs at most `window - max_failed` good frames; a single error, one.
  static constexpr int window = 16;
  static constexpr int max_failed = 4;

  /// Takes a check's outcome in and says whether the message is to be believed. Repeated and absent
  /// data are neither for nor against it, as in AUTOSAR: gateways repeat.
  bool after(E2eStatus status) noexcept {
    const bool behind_error = after_error_;
    if (status != E2eStatus::repeated && status != E2eStatus::no_new_data) {
      const bool failed = status == E2eStatus::error || status == E2eStatus::wrong_sequence;
      failures_ = static_cast<std::uint16_t>(failures_ * 2U + (failed ? 1U : 0U));
      after_error_ = status == E2eStatus::error;
    }
    // Mostly there are none; to count bits is a call where the instruction is not to be relied on.
    const bool few = failures_ == 0 || std::popcount(failures_) <= max_failed;
    return few && !behind_error;
  }

 private:
  std::uint16_t failures_ = 0;  ///< the newest check is the lowest bit
  bool after_error_ = false;    ///< the newest check was an ERROR
};

}  // namespace odomd::can
