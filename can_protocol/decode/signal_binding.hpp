// The configuration of one signal: the message and signal in the database, the unit of its physical
// value, and the conversion to the wanted quantity. Shared by the configuration and the decoder.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::can {

/// Units of a physical value. Conversion to SI happens in the decoder: rad, rad/s, m/s, m/s², 1.
/// SignalBinding::radius_m and ratio convert a rotation of a wheel or motor to its rolling speed.
enum class Unit : std::uint8_t {
  none,
  rad,
  deg,
  rad_per_s,
  deg_per_s,
  m_per_s,
  km_per_h,
  rpm,
  erpm,  ///< electrical turns: `ratio` includes the pole pairs
  m_per_s2,
  g,  ///< 9.80665 m/s²
  percent,
};

enum class Comparison : std::uint8_t { equals, not_equals, below, at_least };
/// The names in configurations, in the order of Comparison.
inline constexpr std::array<std::string_view, 4> comparison_names{"equals", "not_equals", "below",
                                                                  "at_least"};

/// Accepts a sample only if the physical value of another signal of its message compares with
/// `value` like this.
struct ValidWhen {
  std::string signal;
  double value = 0.0;  ///< physical, in the unit of `signal`
  Comparison comparison = Comparison::equals;
};

/// Raw values that mean "not available".
struct UnlessRaw {
  enum class Pattern : std::uint8_t { listed, max, all_ones };
  Pattern pattern = Pattern::listed;
  std::vector<std::int64_t> values;  ///< if listed
};

/// Another signal of the same message that gives the sign of an unsigned quantity.
struct SignSignal {
  std::string signal;
  double negative = 1.0;  ///< physical value of `signal` for negative quantities
};

struct SignalBinding {
  std::uint16_t channel = 0;  ///< the caller's number for the quantity; comes back in Sample
  std::string role;           ///< the caller's name for the quantity, in errors: "wheel_rear_left"
  std::string message;
  std::vector<std::string> signals;    ///< one, or several whose physical values are summed
  std::string bus;                     ///< name of the bus; empty: any
  std::optional<std::uint8_t> source;  ///< address of a J1939 sender; empty: any

  Unit unit = Unit::none;
  double radius_m = 0.0;  ///< of the wheel, for rotations
  double ratio = 1.0;     ///< measured turns per wheel turn, for rotations

  double scale = 1.0;   ///< quantity = scale * value in SI units + offset
  double offset = 0.0;  ///< in SI units

  std::optional<SignSignal> sign;     ///< applied to the sum of the physical values
  std::vector<ValidWhen> valid_when;  ///< all must hold
  /// If empty, raw values at an end of the range are rejected until the source sends another one.
  std::optional<UnlessRaw> unless_raw;

  /// For a direction signal: the physical values for forward (+1) and reverse (-1). The value of
  /// the sample is then +1, -1, or 0 for anything else; unit, scale and offset do not apply.
  std::optional<double> forward;
  std::optional<double> reverse;

  std::int64_t latency_ns = 0;  ///< subtracted from the frame's stamp: the age of the value
};

// End-to-end protection ---------------------------------------------------------------------------

enum class E2eProfile : std::uint8_t { none, p01, p02, p11, p22, counter, sae_j1850 };
/// The names in configurations, in the order of E2eProfile.
inline constexpr std::array<std::string_view, 7> e2e_profile_names{
    "none", "P01", "P02", "P11", "P22", "COUNTER", "SAE_J1850"};

enum class DataIdMode : std::uint8_t { both, alternating, low, nibble };

/// Protection of one message, as in [can.e2e]. CRC and counter are signals of the message.
struct E2eBinding {
  std::string message;
  E2eProfile profile = E2eProfile::none;
  std::uint16_t data_id = 0;
  DataIdMode data_id_mode = DataIdMode::both;
  std::vector<std::uint8_t> data_id_list;  ///< profiles 2 and 22: 16 entries
  std::string crc_signal;
  std::string counter_signal;
  std::uint8_t max_delta_counter = 3;  ///< a larger step of the counter is WRONGSEQUENCE
};

}  // namespace odomd::can
