// Frames to values and back, as a configuration maps them: what a fault is applied to. Both ways in
// SI units; only the bits of the signal that is written change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/decoder_tables.hpp"
#include "can_protocol/decode/e2e.hpp"
#include "can_protocol/frame.hpp"
#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::fault {

/// One quantity in a frame.
struct Reading {
  std::uint32_t binding = 0;
  estimator::Source source = estimator::Source::yaw_rate;
  double value = 0.0;
};

class CarSignals {
 public:
  /// Throws std::invalid_argument where the configuration does not fit the databases.
  CarSignals(const daemon::CanConfig& config, std::span<const can::Database> databases,
             std::span<const std::string> bus_names);

  /// Which bound message a frame is; nothing where no binding wants it.
  [[nodiscard]] std::optional<std::size_t> message_of(const can::Frame& frame) const noexcept;

  /// Whether the message carries one of the sources.
  [[nodiscard]] bool carries(std::size_t message, std::uint32_t sources) const noexcept;

  /// The values in a frame, at most can::max_samples_per_frame; returns how many.
  std::size_t read(std::size_t message, const can::Frame& frame,
                   std::span<Reading> readings) const noexcept;

  /// Puts the nearest value that its bits can hold; counter and CRC are left as they are. NaN is
  /// left out of signals that are integers.
  void write(std::uint32_t binding_index, double value, can::Frame& frame) const noexcept;

  /// Turns one of the signal's bits, the one that `draw` (of any size) falls on.
  void flip_bit(std::uint32_t binding_index, std::uint64_t draw, can::Frame& frame) const noexcept;

  /// Whether the frame's protection holds, and its counter into `counter`.
  [[nodiscard]] bool is_protected_right(std::size_t message, const can::Frame& frame,
                                        can::E2eState& counter) const noexcept;
  /// Makes the CRC right again under the counter that follows `counter`; nothing where the message
  /// is not protected.
  void protect(std::size_t message, can::Frame& frame, can::E2eState& counter) const noexcept;
  /// The same under the frame's own counter, `own`.
  void repair(std::size_t message, can::Frame& frame, const can::E2eState& own) const noexcept;

  [[nodiscard]] std::size_t message_count() const noexcept { return tables_.messages.size(); }

 private:
  can::Decoder::Tables tables_;
};

}  // namespace odomd::fault
