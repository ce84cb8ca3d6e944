// The layout is that of the VESC firmware, documentation/comm_can.md and comm_can.c. STATUS_6 has
// number 58, as in datatypes.h; the document says 28.
#include "tools/init/proposal.hpp"

#include <array>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

/// A signal: signed, big-endian. The signals of a packet follow each other.
struct Field {
  std::uint32_t packet;
  std::string_view message, signal;
  std::uint32_t bits;
  std::string_view scale, unit;
};

constexpr std::uint32_t speed_packet = 9;
constexpr auto fields = std::to_array<Field>({
    {speed_packet, "STATUS", "MotorERPM", 32, "1", "erpm"},
    {speed_packet, "STATUS", "Current", 16, "0.1", "A"},
    {speed_packet, "STATUS", "DutyCycle", 16, "0.1", "%"},
    {14, "STATUS_2", "ChargeUsed", 32, "0.0001", "Ah"},
    {14, "STATUS_2", "ChargeRegained", 32, "0.0001", "Ah"},
    {15, "STATUS_3", "EnergyUsed", 32, "0.0001", "Wh"},
    {15, "STATUS_3", "EnergyRegained", 32, "0.0001", "Wh"},
    {16, "STATUS_4", "TemperatureFET", 16, "0.1", "degC"},
    {16, "STATUS_4", "TemperatureMotor", 16, "0.1", "degC"},
    {16, "STATUS_4", "CurrentIn", 16, "0.1", "A"},
    {16, "STATUS_4", "PIDPosition", 16, "0.02", "deg"},
    {27, "STATUS_5", "Tachometer", 32, "0.16666666666666666", "erev"},
    {27, "STATUS_5", "VoltageIn", 16, "0.1", "V"},
    {58, "STATUS_6", "ADC1", 16, "0.001", "V"},
    {58, "STATUS_6", "ADC2", 16, "0.001", "V"},
    {58, "STATUS_6", "ADC3", 16, "0.001", "V"},
    {58, "STATUS_6", "PPMInput", 16, "0.1", "%"},
});
constexpr std::string_view frame_setting =
    "VESC Tool, App Settings, General: CAN Mode VESC, CAN Status Message 1 at 50 Hz or more";

std::uint32_t frame_id(std::uint32_t packet, int vesc) {
  return packet << 8U | static_cast<std::uint32_t>(vesc);
}

}  // namespace

std::string vesc_database(int id) {
  std::string text = fmt::format("VERSION \"\"\n\nBU_: VESC_{}\n", id);
  std::uint32_t packet = 0, bit = 0;
  for (const Field& field : fields) {
    if (std::exchange(packet, field.packet) != field.packet) {
      const auto key = can::frame_key(frame_id(packet, id), can::IdFormat::extended);
      text += fmt::format("\nBO_ {0} VESC_{1}_{2}: 8 VESC_{1}\n", key, id, field.message);
      bit = 0;
    }
    // The start of a big-endian signal is its highest bit.
    text += fmt::format(" SG_ {} : {}|{}@0- ({},0) [-1e9|1e9] \"{}\" Vector__XXX\n", field.signal,
                        bit + 7, field.bits, field.scale, field.unit);
    bit += field.bits;
  }
  return text + fmt::format("\nCM_ \"Frames of VESC {0}, made by odom init --vesc {0}.\";\n", id);
}

void require_frames(int vesc, const Traffic& traffic) {
  constexpr std::uint32_t all_controllers = 255;
  std::set<std::uint32_t> senders;
  for (const can::Frame& frame : traffic.frames)
    if (const std::uint32_t id = frame.id - frame_id(speed_packet, 0);
        frame.format == can::IdFormat::extended && id < all_controllers && frame.length == 8)
      senders.insert(id);
  if (senders.contains(static_cast<std::uint32_t>(vesc))) return;
  refuse("{}: VESC {} does not send STATUS (identifier {:X}) there; {}", traffic.name, vesc,
         frame_id(speed_packet, vesc),
         senders.empty() ? fmt::format("switch it on: {}", frame_setting)
                         : fmt::format("it comes from VESC {}: give that number with --vesc",
                                       fmt::join(senders, " and ")));
}

void settle_motor(Proposal& proposal, int vesc, Car& car) {
  auto& motor = proposal.of(estimator::Source::motor);
  if (!motor) {
    proposal.notes.push_back(
        fmt::format("VESC {} is not mapped: wheel speeds take its place; if the car has none, "
                    "give --can with a drive",
                    vesc));
    return;
  }
  if (!car.gear_ratio) {
    car.gear_ratio = 1.0;
    motor->warnings.emplace_back(
        "ratio 1: a wheel that turns with its motor; with gears give --gear-ratio");
  }
  constexpr double slow_s = 0.05;
  if (motor->series.cycle() > 1.02 * slow_s)  // stamps jitter
    motor->warnings.push_back(
        fmt::format("it comes less than {:g} times a second; {}", 1.0 / slow_s, frame_setting));
  if (!proposal.has(estimator::Source::yaw_rate))
    proposal.notes.push_back(
        fmt::format("VESC {} sends no yaw rate and no steering angle: add the database of the "
                    "node that does with --dbc",
                    vesc));
}

}  // namespace odomd::tools
