// Converts frames to values and back, as mapped by a configuration, to apply faults to them. Values
// are in SI units; writing changes only the bits of the signal.
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
  /// Throws std::invalid_argument if the configuration does not fit the databases.
  CarSignals(const daemon::CanConfig& config, std::span<const can::Database> databases,
             std::span<const std::string> bus_names);

  /// The bound message of a frame; empty if no binding uses the frame.
  [[nodiscard]] std::optional<std::size_t> message_of(const can::Frame& frame) const noexcept;

  /// Whether the message carries one of the sources.
  [[nodiscard]] bool carries(std::size_t message, std::uint32_t sources) const noexcept;

  /// Reads the values in a frame, at most can::max_samples_per_frame; returns their number.
  std::size_t read(std::size_t message, const can::Frame& frame,
                   std::span<Reading> readings) const noexcept;

  /// Writes the nearest value that the signal can hold; counter and CRC are not changed. NaN is not
  /// written to integer signals.
  void write(std::uint32_t binding_index, double value, can::Frame& frame) const noexcept;

  /// Flips one of the signal's bits, selected by `draw` (of any size).
  void flip_bit(std::uint32_t binding_index, std::uint64_t draw, can::Frame& frame) const noexcept;

  /// Whether the frame's protection is valid; writes its counter to `counter`.
  [[nodiscard]] bool is_protected_right(std::size_t message, const can::Frame& frame,
                                        can::E2eState& counter) const noexcept;
  /// Recomputes the CRC with the counter that follows `counter`; does nothing if the message is not
  /// protected.
  void protect(std::size_t message, can::Frame& frame, can::E2eState& counter) const noexcept;
  /// Recomputes the CRC with the frame's own counter, `own`.
  void repair(std::size_t message, can::Frame& frame, const can::E2eState& own) const noexcept;

  [[nodiscard]] std::size_t message_count() const noexcept { return tables_.messages.size(); }

 private:
  can::Decoder::Tables tables_;
};

}  // namespace odomd::fault
