// The meaning of the words in signals' names, in English, German and French, for roles.cpp and
// companions.cpp.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "can_protocol/decode/name_hints.hpp"

namespace odomd::tools {

using Vocabulary = std::span<const std::string_view>;

/// The words of a name, with compounds split: "Lenkradwinkel" into lenkrad and winkel, "yawrate"
/// into yaw and rate.
[[nodiscard]] can::NameWords split_words(std::string_view name);

/// Whether a word of the name means an entry: "speed", "spd" and "speedfront" mean "speed".
[[nodiscard]] bool has(const can::NameWords& name, Vocabulary vocabulary);

/// Like has(), but a word must equal the entry: "acc" alone is a system, "accel" an acceleration.
[[nodiscard]] bool has_word(const can::NameWords& name, Vocabulary vocabulary);

/// The words from which roles.cpp infers what a signal measures, and what it does not.
namespace role_words {

inline constexpr auto yaw = std::to_array<std::string_view>({"yaw", "gier", "lacet", "gyro"});
inline constexpr auto rate = std::to_array<std::string_view>(
    {"rate", "speed", "velocity", "gyro", "omega", "geschwindigkeit"});
inline constexpr auto acceleration = std::to_array<std::string_view>(
    {"acceleration", "accel", "beschleunigung", "beschl", "ax", "ay", "ac"});
inline constexpr auto along =
    std::to_array<std::string_view>({"x", "ax", "longitudinal", "laengs", "forward"});
inline constexpr auto across =
    std::to_array<std::string_view>({"y", "ay", "lateral", "quer", "transversal"});
inline constexpr auto wheel =
    std::to_array<std::string_view>({"wheel", "whl", "rad", "roue", "rueda", "ruota", "wss", "ws"});
inline constexpr auto speed = std::to_array<std::string_view>(
    {"speed", "velocity", "geschwindigkeit", "vitesse", "v", "encoder", "rpm", "erpm", "drehzahl"});
inline constexpr auto car =
    std::to_array<std::string_view>({"vehicle", "car", "fahrzeug", "fzg", "ego", "host"});
inline constexpr auto motor =
    std::to_array<std::string_view>({"motor", "erpm", "inverter", "traction", "vesc"});
inline constexpr std::string_view electrical = "erpm";
inline constexpr auto steering = std::to_array<std::string_view>(
    {"steering", "steer", "lenkrad", "lenk", "volant", "sas", "swa", "lws"});
inline constexpr auto angle =
    std::to_array<std::string_view>({"angle", "winkel", "position", "steering", "lenkwinkel"});
inline constexpr auto front = std::to_array<std::string_view>({"front", "vorne", "vorn", "avant"});
inline constexpr auto rear = std::to_array<std::string_view>({"rear", "back", "hinten", "arriere"});
inline constexpr auto left =
    std::to_array<std::string_view>({"left", "links", "gauche", "lh", "l"});
inline constexpr auto right =
    std::to_array<std::string_view>({"right", "rechts", "droite", "rh", "r"});
inline constexpr auto fraction_words =
    std::to_array<std::string_view>({"fraction", "fractional", "fine"});

/// Abbreviations of the wheels in English and German: front left, front right, ...
inline constexpr std::array corner_codes{
    std::to_array<std::string_view>({"fl", "lf", "vl"}),
    std::to_array<std::string_view>({"fr", "rf", "vr"}),
    std::to_array<std::string_view>({"rl", "lr", "hl"}),
    std::to_array<std::string_view>({"rr", "rr", "hr"}),
};

/// Words of other quantities: set values, limits, counters, states of a signal.
inline constexpr auto other_quantity = std::to_array<std::string_view>(
    {"target",      "trgt",      "tgt",     "requested", "request",    "req",        "rqst",
     "rq",          "desired",   "soll",    "setpoint",  "set",        "limit",      "maximum",
     "max",         "minimum",   "min",     "offset",    "offst",      "bias",       "torque",
     "crc",         "checksum",  "chksm",   "counter",   "cnt",        "valid",      "validity",
     "quality",     "qf",        "qbit",    "fault",     "error",      "err",        "pressure",
     "pulse",       "tick",      "cruise",  "lead",      "object",     "obj",        "relative",
     "rel",         "pedal",     "ped",     "gradient",  "sign",       "vorzeichen", "vz",
     "curvature",   "gps",       "gnss",    "roll",      "pitch",      "vertical",   "radius",
     "temperature", "timestamp", "default", "threshold", "difference", "lkas",       "lka",
     "display",     "disp",      "dsply",   "index",     "button",     "knob",       "switch"});
/// Words that may mean another quantity.
inline constexpr auto perhaps_other = std::to_array<std::string_view>(
    {"status", "state", "estimated", "ui", "command", "cmd", "getriebe"});
/// Words of signals and messages that are not about the car.
inline constexpr auto other_thing = std::to_array<std::string_view>(
    {"trailer", "trlr", "anhaenger", "track", "trk", "object", "obj", "vision", "vsn"});
/// Words for the position of the gear lever, which is not the gear itself.
inline constexpr auto gear_lever =
    std::to_array<std::string_view>({"lever", "lvr", "selector", "shifter", "shift"});
inline constexpr auto gear = std::to_array<std::string_view>(
    {"gear", "direction", "dircn", "dir", "drive", "fahrstufe", "gang", "travel", "range"});
/// Unit texts that mean "dimensionless".
inline constexpr auto no_dimension = std::to_array<std::string_view>(
    {"unitless", "discrete", "sed", "count", "counts", "enum", "bool", "encrypted", "mixed"});

}  // namespace role_words

}  // namespace odomd::tools
