// Names are compared word by word.
#include "can_protocol/decode/name_hints.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

#include "base/nearest_name.hpp"
#include "can_protocol/decode/units.hpp"

namespace odomd::can {
namespace {

bool is_lower(char c) {
  return std::islower(static_cast<unsigned char>(c)) != 0;
}
bool is_upper(char c) {
  return std::isupper(static_cast<unsigned char>(c)) != 0;
}
bool is_letter(char c) {
  return is_lower(c) || is_upper(c);
}

/// Counts the words that the name contains, one by one or as initials: "RL" is rear and left.
int common_words(const NameWords& words, const NameWords& name) {
  std::string initials;
  for (const std::string& word : words) initials += word[0];
  int common = 0;
  for (const std::string& word : words)
    common += static_cast<int>(std::ranges::any_of(name, [&](const std::string& other) {
      return word == other || abbreviates(word, other) || abbreviates(other, word);
    }));
  for (const std::string& word : name)
    if (word.size() > 1 && initials.find(word) != std::string::npos)
      common += static_cast<int>(word.size());
  return common;
}

/// The signal that a binding wants.
struct Wanted {
  NameWords quantity;  ///< words of role and signals
  NameWords
      distinctive;  ///< one must match: the role's first word, or a signal's that the role lacks
  NameWords message;
  Dimension dimension;
};

Wanted wanted_by(const SignalBinding& binding) {
  Wanted wanted{words_of(binding.role), {}, words_of(binding.message), dimension_of(binding.unit)};
  if (!wanted.quantity.empty()) wanted.distinctive.push_back(wanted.quantity.front());
  for (const std::string& signal : binding.signals)
    for (const std::string& word : words_of(signal))
      if (std::ranges::find(wanted.quantity, word) == wanted.quantity.end()) {
        wanted.quantity.push_back(word);
        wanted.distinctive.push_back(word);
      }
  return wanted;
}

/// How well a signal fits: its words count most, then its unit, then its message. 0: not at all.
int fitness(const Wanted& wanted, const NameWords& message, const Signal& signal) {
  const auto unit = unit_of_text(signal.unit);
  const bool measures = unit && dimension_of(*unit) == wanted.dimension;
  constexpr int shortest_measurement = 8;  // bits; a flag has fewer, and often no unit
  if (wanted.dimension != Dimension::none && !measures &&
      (unit || is_other_unit(signal.unit) || signal.length < shortest_measurement))
    return 0;
  const NameWords name = words_of(signal.name);
  if (common_words(wanted.distinctive, name) + common_words(wanted.distinctive, message) == 0)
    return 0;
  const int own = common_words(wanted.quantity, name);
  const int around = common_words(wanted.quantity, message) + common_words(wanted.message, message);
  if (own == 0 && !(measures && around > 0)) return 0;
  return 4 * own + (measures ? 3 : 0) + around;
}

/// "; signal 'YawRate' (deg/s) of message 'Inertial' would fit", or nothing.
std::string fitting_hint(std::span<const Database> databases, const SignalBinding& binding) {
  const Wanted wanted = wanted_by(binding);
  const Message* message = nullptr;
  const Signal* signal = nullptr;
  int best = 0;
  for (const Database& database : databases)
    for (const Message& candidate : database.messages) {
      const NameWords around = words_of(candidate.name);
      for (const Signal& other : candidate.signals) {
        const int fit = fitness(wanted, around, other);
        if (fit <= best) continue;
        best = fit;
        message = &candidate;
        signal = &other;
      }
    }
  if (signal == nullptr) return {};
  return "; signal '" + signal->name + "'" +
         (signal->unit.empty() ? "" : " (" + signal->unit + ")") + " of message '" + message->name +
         "' would fit";
}

std::vector<std::string> names_of(const Message& message) {
  std::vector<std::string> names;
  for (const Signal& signal : message.signals) names.push_back(signal.name);
  return names;
}

std::string nearest(std::string_view name) {
  return std::string("; the nearest is '").append(name).append("'");
}

/// "; it was left out in line 9: expected ..."; empty if the name was not left out.
std::string left_out_hint(const std::vector<LeftOut>& all, std::string_view name) {
  const auto found = std::ranges::find(all, name, &LeftOut::name);
  if (found == all.end()) return {};
  return "; it was left out in line " + std::to_string(found->line) + ": " + found->why;
}

std::string likely_message_hint(std::span<const Database> databases, std::string_view message) {
  std::vector<std::string> names;
  for (const Database& database : databases) {
    if (std::string hint = left_out_hint(database.left_out, message); !hint.empty()) return hint;
    for (const Message& candidate : database.messages) names.push_back(candidate.name);
  }
  const std::string_view likely = likely_name(message, names);
  return likely.empty() ? std::string{} : nearest(likely);
}

std::string list_hint(std::span<const Database> databases) {
  return "; odom dbc show " + (databases.size() == 1 ? databases.front().file : "DBC") +
         " lists those there are";
}

}  // namespace

NameWords words_of(std::string_view name) {
  NameWords words;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!is_letter(name[i])) continue;
    const bool hump = is_upper(name[i]) && i > 0 &&
                      (is_lower(name[i - 1]) || (i + 1 < name.size() && is_lower(name[i + 1])));
    if (i == 0 || !is_letter(name[i - 1]) || hump) words.emplace_back();
    words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
  }
  return words;
}

bool abbreviates(std::string_view shorter, std::string_view longer) {
  constexpr std::size_t distinctive = 3;
  if (shorter.size() < distinctive || shorter.size() > longer.size() || shorter[0] != longer[0])
    return false;
  std::size_t at = 0;
  for (const char c : longer)
    if (at < shorter.size() && shorter[at] == c) ++at;
  return at == shorter.size();
}

std::string message_hint(std::span<const Database> databases, const SignalBinding& binding) {
  std::string hint = likely_message_hint(databases, binding.message);
  if (hint.empty()) hint = fitting_hint(databases, binding);
  return hint.empty() ? list_hint(databases) : hint;
}

std::string message_hint(std::span<const Database> databases, std::string_view message) {
  const std::string hint = likely_message_hint(databases, message);
  return hint.empty() ? list_hint(databases) : hint;
}

std::string signal_hint(std::span<const Database> databases, const Message& message,
                        const SignalBinding& binding, std::string_view signal) {
  if (std::string hint = left_out_hint(message.left_out, signal); !hint.empty()) return hint;
  const std::vector<std::string> names = names_of(message);
  const std::string_view likely = likely_name(signal, names);
  if (!likely.empty()) return nearest(likely);
  const std::string hint = fitting_hint(databases, binding);
  return hint.empty() ? list_hint(databases) : hint;
}

std::string nearest_signal_hint(const Message& message, std::string_view signal) {
  const std::string hint = left_out_hint(message.left_out, signal);
  return hint.empty() ? nearest_hint(signal, names_of(message)) : hint;
}

}  // namespace odomd::can
