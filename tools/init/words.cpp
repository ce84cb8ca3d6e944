#include "tools/init/words.hpp"

#include <algorithm>
#include <array>

namespace odomd::tools {
namespace {

// Words that are often joined without a capital letter or an underscore in between.
constexpr auto stems = std::to_array<std::string_view>(
    {"yaw",    "gier",     "rate",   "speed",          "geschwindigkeit", "geschw",
     "accel",  "acc",      "beschl", "beschleunigung", "acceleration",    "laengs",
     "quer",   "long",     "lat",    "lateral",        "wheel",           "rad",
     "roue",   "drehzahl", "lenk",   "lenkrad",        "steering",        "steer",
     "angle",  "winkel",   "motor",  "vehicle",        "front",           "rear",
     "left",   "right",    "limit",  "target",         "request",         "counter",
     "sensor", "status",   "valid",  "longitudinal",   "velocity"});
constexpr auto endings =
    std::to_array<std::string_view>({"fl", "fr", "rl", "rr", "vl", "vr", "hl", "hr", "x", "y"});

/// Appends the parts of a word if it consists of known parts only.
bool split(std::string_view word, can::NameWords& parts) {
  const auto ends = [&](Vocabulary words) { return std::ranges::find(words, word) != words.end(); };
  if (ends(stems) || ends(endings)) {
    parts.emplace_back(word);
    return true;
  }
  for (const std::string_view stem : stems) {
    if (!word.starts_with(stem)) continue;
    const std::size_t before = parts.size();
    parts.emplace_back(stem);
    if (split(word.substr(stem.size()), parts)) return true;
    parts.resize(before);
  }
  return false;
}

/// Whether a word means an entry; short words must be equal.
bool means(const std::string& word, std::string_view entry) {
  constexpr std::size_t long_entry = 5, compound = 3;
  const bool plural =
      word.size() == entry.size() + 1 && word.starts_with(entry) && word.back() == 's';
  return word == entry || plural || (entry.size() >= long_entry && can::abbreviates(word, entry)) ||
         (entry.size() >= compound && word.size() >= entry.size() + compound &&
          word.starts_with(entry));
}

}  // namespace

can::NameWords split_words(std::string_view name) {
  can::NameWords words;
  for (std::string& word : can::words_of(name))
    if (!split(word, words)) words.push_back(std::move(word));
  return words;
}

bool has(const can::NameWords& name, Vocabulary vocabulary) {
  return std::ranges::any_of(name, [&](const std::string& word) {
    return std::ranges::any_of(vocabulary,
                               [&](std::string_view entry) { return means(word, entry); });
  });
}

bool has_word(const can::NameWords& name, Vocabulary vocabulary) {
  return std::ranges::any_of(name, [&](const std::string& word) {
    return std::ranges::find(vocabulary, word) != vocabulary.end();
  });
}

}  // namespace odomd::tools
