// Layouts: VESC firmware, documentation/comm_can.md and comm_can.c (STATUS_6 has number 58, as in
// datatypes.h; the document says 28). ODrive firmware, docs/can-protocol.rst.
#include "tools/init/motor_controller.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace odomd::tools {
namespace {

/// A signal. The signals of a packet follow each other.
struct Field {
  std::uint32_t packet = 0;
  std::string_view message;
  std::string_view signal;
  std::uint32_t bits = 0;
  std::string_view scale, unit;
};

// The packet with the speed comes first.
constexpr auto vesc_fields = std::to_array<Field>({
    {9, "STATUS", "MotorERPM", 32, "1", "erpm"},
    {9, "STATUS", "Current", 16, "0.1", "A"},
    {9, "STATUS", "DutyCycle", 16, "0.1", "%"},
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
constexpr auto odrive_fields = std::to_array<Field>({
    {9, "ESTIMATES", "Position", 32, "1", "rev"},
    {9, "ESTIMATES", "MotorSpeed", 32, "60", "rpm"},
});

}  // namespace

struct ControllerLayout {
  std::string_view name, word;  ///< "VESC"; "vesc" in options and file names
  std::uint32_t max_id = 0;
  can::IdFormat format{};
  std::uint32_t id_shift = 0, packet_shift = 0;
  can::ValueType type{};  ///< integers are big-endian, floats little-endian
  std::span<const Field> fields;
  std::string_view id_setting;     ///< the setting with the controller's number
  std::string_view frame_setting;  ///< the setting that switches the frame with the speed on

  [[nodiscard]] std::uint32_t frame_id(std::uint32_t packet, std::uint32_t id) const {
    return packet << packet_shift | id << id_shift;
  }
};

namespace {

// VESC 255 addresses all controllers.
constexpr ControllerLayout vesc{
    "VESC",
    "vesc",
    254,
    can::IdFormat::extended,
    0,
    8,
    can::ValueType::signed_integer,
    vesc_fields,
    "VESC Tool shows it under App Settings, General, VESC ID",
    "VESC Tool, App Settings, General: CAN Mode VESC, CAN Status Message 1 at 50 Hz or more"};
constexpr ControllerLayout odrive{
    "ODrive",
    "odrive",
    63,
    can::IdFormat::standard,
    5,
    0,
    can::ValueType::float32,
    odrive_fields,
    "it is axis.config.can.node_id, with standard identifiers",
    "odrivetool: axis.config.can.encoder_rate_ms = 10 (newer firmware: encoder_msg_rate_ms)"};

MotorController parse_id(const ControllerLayout& layout, const std::string& text) {
  std::uint32_t id = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, id);
  if (error != std::errc{} || rest != end || id > layout.max_id)
    throw std::invalid_argument(
        fmt::format("--{}: '{}' is no number of this controller: 0 to {}; {}", layout.word, text,
                    layout.max_id, layout.id_setting));
  return {&layout, id};
}

/// Numbers of this kind's controllers that send the packet.
std::set<std::uint32_t> senders_of(std::uint32_t packet, const ControllerLayout& layout,
                                   const Traffic& traffic) {
  std::set<std::uint32_t> ids;
  for (const can::Frame& frame : traffic.frames) {
    const std::uint32_t id = (frame.id - layout.frame_id(packet, 0)) >> layout.id_shift;
    if (frame.format == layout.format && id <= layout.max_id &&
        frame.id == layout.frame_id(packet, id) && frame.length == 8)
      ids.insert(id);
  }
  return ids;
}

}  // namespace

std::string MotorController::name() const {
  return fmt::format("{} {}", layout->name, id);
}

std::optional<MotorController> parse_controller(const ControllerTexts& texts) {
  std::vector<MotorController> all;
  for (const std::string& text : texts.vesc) all.push_back(parse_id(vesc, text));
  for (const std::string& text : texts.odrive) all.push_back(parse_id(odrive, text));
  if (all.empty()) return std::nullopt;
  if (all.size() > 1)
    throw std::invalid_argument(fmt::format(
        "{} and {}: name one controller, that of the driven rear axle; odomd has one role motor. "
        "With a motor at each rear wheel run odom init for each with another --out, then give both "
        "databases in can.dbc and map wheel_rear_left and wheel_rear_right instead of motor",
        all[0].name(), all[1].name()));
  return all.front();
}

MadeDatabase make_database(const MotorController& controller) {
  const ControllerLayout& layout = *controller.layout;
  const bool is_float = layout.type == can::ValueType::float32;
  const std::string node = fmt::format("{}_{}", layout.name, controller.id);
  std::string text = "VERSION \"\"\n\nBU_: " + node + "\n";
  std::string types;
  std::uint32_t packet = 0, bit = 0;
  for (const Field& field : layout.fields) {
    const std::uint32_t number =
        can::frame_key(layout.frame_id(field.packet, controller.id), layout.format);
    if (std::exchange(packet, field.packet) != field.packet) {
      text += fmt::format("\nBO_ {} {}_{}: 8 {}\n", number, node, field.message, node);
      bit = 0;
    }
    // The start of a big-endian signal is its highest bit.
    text += fmt::format(" SG_ {} : {}|{}@{}- ({},0) [-1e9|1e9] \"{}\" Vector__XXX\n", field.signal,
                        is_float ? bit : bit + 7, field.bits, is_float ? 1 : 0, field.scale,
                        field.unit);
    if (is_float) types += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", number, field.signal);
    bit += field.bits;
  }
  text += fmt::format("\nCM_ \"Frames of {}, made by odom init --{} {}.\";\n", controller.name(),
                      layout.word, controller.id);
  return {fmt::format("{}-{}.dbc", layout.word, controller.id), text + types};
}

void require_frames(const MotorController& controller, const Traffic& traffic) {
  const ControllerLayout& layout = *controller.layout;
  const Field& speed = layout.fields.front();
  const std::set<std::uint32_t> seen = senders_of(speed.packet, layout, traffic);
  if (seen.contains(controller.id)) return;
  const std::string fix = seen.empty()
                              ? fmt::format("switch it on: {}", layout.frame_setting)
                              : fmt::format("it comes from {} {}: give that number with --{}",
                                            layout.name, fmt::join(seen, " and "), layout.word);
  throw std::invalid_argument(fmt::format("{}: {} does not send {} (identifier {:X}) there; {}",
                                          traffic.name, controller.name(), speed.message,
                                          layout.frame_id(speed.packet, controller.id), fix));
}

void settle_motor(Proposal& proposal, const MotorController& controller, Car& car, bool can_ask) {
  auto& motor = proposal.of(estimator::Source::motor);
  if (!motor) {
    proposal.notes.push_back(controller.name() +
                             " is not mapped: wheel speeds take its place; if the car has none, "
                             "give --can with a drive");
    return;
  }
  if (!car.gear_ratio && !can_ask) {
    car.gear_ratio = 1.0;
    motor->warnings.emplace_back(
        "ratio 1: a wheel that turns with its motor; with gears give --gear-ratio");
  }
  constexpr double slow_s = 0.05;
  const Series& series = motor->series;
  if (const auto count = static_cast<double>(series.size());
      count > 1.0 &&
      1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front()) > slow_s * count)
    motor->warnings.push_back(fmt::format("it comes less than {:g} times a second; {}",
                                          1.0 / slow_s, controller.layout->frame_setting));
  if (!proposal.has(estimator::Source::yaw_rate))
    proposal.notes.push_back(controller.name() +
                             " sends no yaw rate and no steering angle: add the database of the "
                             "node that does with --dbc");
}

}  // namespace odomd::tools
