// The meaning of the words in signals' names, in English, German and French, for roles.cpp and
// companions.cpp.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "can_protocol/decode/name_words.hpp"

namespace odomd::tools {

using Vocabulary = std::span<const std::string_view>;

/// The words of a name, with compounds split: "Lenkradwinkel" into lenkrad and winkel, "yawrate"
/// into yaw and rate.
[[nodiscard]] can::NameWords split_words(std::string_view name);

/// Whether a word of the name means an entry: "speed", "spd" and "speedfront" mean "speed".
[[nodiscard]] bool has(const can::NameWords& name, Vocabulary vocabulary);

/// Like has(), but a word must equal the entry: "acc" alone is a system, "accel" an acceleration.
[[nodiscard]] bool has_word(const can::NameWords& name, Vocabulary vocabulary);

}  // namespace odomd::tools
