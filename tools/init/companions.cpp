// A companion's name without a token is its signal's name or its beginning: "IMU_YawSigSta" belongs
// to "IMU_YawRtVal".
#include "tools/init/proposal.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include <fmt/format.h>

#include "can_protocol/dbc/signal_layout.hpp"
#include "tools/init/words.hpp"

namespace odomd::tools {
namespace {

constexpr auto validity = std::to_array<std::string_view>(
    {"validity", "valid",  "vld",  "available", "qualitybit", "quality", "qbit",    "dqf",   "qf",
     "sigsta",   "status", "stat", "sts",       "sta",        "state",   "invalid", "fault", "falt",
     "flt",      "error",  "err",  "fehler",    "fail",       "ok",      "v"});
constexpr auto sign = std::to_array<std::string_view>(
    {"vorzeichen", "vz", "signbit", "sign", "sgn", "direction", "dircn", "richtung", "dir"});

constexpr auto good = std::to_array<std::string_view>(
    {"valid", "ok", "okay", "normal", "good", "true", "available", "gueltig", "plausible"});
constexpr auto bad = std::to_array<std::string_view>(
    {"invalid",     "fault",        "faulty",      "error",   "fail",         "failed",
     "failure",     "false",        "init",        "initial", "initialising", "initializing",
     "unknown",     "undefined",    "unavailable", "sna",     "fehler",       "ungueltig",
     "implausible", "nodataexists", "reserved"});
constexpr auto no = std::to_array<std::string_view>({"no", "not", "none", "kein", "without"});
constexpr auto negative =
    std::to_array<std::string_view>({"right", "rechts", "negative", "negativ", "minus", "backward",
                                     "backwards", "reverse", "rueckwaerts"});

/// The letters and digits in lower case.
std::string squeezed(std::string_view name) {
  std::string text;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

enum class Match : std::uint8_t { none, message, begin, whole };

/// What `candidate`, with a token removed, matches: the signal, its beginning, or the message.
Match match(const can::Message& message, const can::Signal& measured, const can::Signal& candidate,
            Vocabulary tokens) {
  const std::string name = squeezed(candidate.name), own = squeezed(measured.name);
  Match best = Match::none;
  for (const std::string_view token : tokens)
    for (auto at = name.find(token); at != std::string::npos; at = name.find(token, at + 1)) {
      const std::string rest = std::string(name).erase(at, token.size());
      if (rest == own) return Match::whole;
      if (token.size() == 1 ||
          (!rest.empty() && !own.starts_with(rest) && !squeezed(message.name).starts_with(rest)))
        continue;
      const auto others = std::ranges::count_if(message.signals, [&](const can::Signal& signal) {
        return &signal != &candidate && squeezed(signal.name).starts_with(rest);
      });
      constexpr std::size_t telling = 4;
      const bool of_one = own.starts_with(rest) && rest.size() >= telling &&
                          static_cast<std::size_t>(others) + 1 < message.signals.size();
      best = std::max(best, of_one ? Match::begin : Match::message);
    }
  return best;
}

double physical(const can::Signal& signal, std::int64_t raw) {
  return static_cast<double>(raw) * signal.scale + signal.offset;
}

bool is_good(const can::ValueName& value) {
  const can::NameWords words = split_words(value.name);
  return has_word(words, no) ? has_word(words, bad) : has_word(words, good);
}

bool is_bad(const can::ValueName& value) {
  const can::NameWords words = split_words(value.name);
  const bool nothing =
      has_word(words, no) &&
      has_word(words, std::to_array<std::string_view>({"data", "available", "valid"}));
  return nothing || (has_word(words, bad) && !has_word(words, no));
}

/// Whether a named value fits into the signal, which is not so in all databases.
bool has_raw(const can::Signal& signal, std::int64_t raw) {
  const can::SignalLayout layout = can::layout_of(signal);
  const auto bits = static_cast<std::uint64_t>(raw) & can::low_bits(signal.length);
  return can::raw_value(layout, bits) == static_cast<double>(raw);
}

/// The value for which `named` holds; nothing unless there is exactly one.
template <class Named>
std::optional<double> value_where(const can::Signal& signal, Named named) {
  if (std::ranges::count_if(signal.values, named) != 1) return std::nullopt;
  const std::int64_t raw = std::ranges::find_if(signal.values, named)->raw;
  return has_raw(signal, raw) ? std::optional(physical(signal, raw)) : std::nullopt;
}

}  // namespace

std::vector<Companion> validity_of(const can::Message& message, const can::Signal& measured) {
  constexpr int longest = 4;  // bits
  std::vector<Companion> found;
  for (const can::Signal& signal : message.signals) {
    if (&signal == &measured || signal.length > longest ||
        signal.multiplexor != measured.multiplexor)
      continue;
    const auto value = value_where(signal, is_good);
    const Match how = match(message, measured, signal, validity);
    const bool speaks = value.has_value() || signal.length == 1;  // needed for a whole message
    if (how >= Match::begin || (how == Match::message && speaks)) found.push_back({&signal, value});
  }
  return found;
}

std::optional<Companion> sign_of(const can::Message& message, const can::Signal& measured) {
  constexpr int longest = 3;  // bits
  if (measured.type != can::ValueType::unsigned_integer || measured.minimum < 0.0 ||
      measured.offset < 0.0)
    return std::nullopt;
  std::optional<Companion> found;
  Match best = Match::message;
  for (const can::Signal& signal : message.signals) {
    if (&signal == &measured || signal.length > longest ||
        signal.multiplexor != measured.multiplexor)
      continue;
    const Match how = match(message, measured, signal, sign);
    const auto value = value_where(signal, [](const can::ValueName& one) {
      return has_word(split_words(one.name), negative);
    });
    if (how <= best || (signal.length > 1 && !value)) continue;
    best = how;
    found = {&signal, value.value_or(physical(signal, has_raw(signal, 1) ? 1 : -1))};
  }
  return found;
}

std::vector<std::int64_t> invalid_raws(const can::Signal& measured) {
  std::vector<std::int64_t> raws;
  if (measured.type != can::ValueType::unsigned_integer &&
      measured.type != can::ValueType::signed_integer)
    return raws;
  for (const can::ValueName& value : measured.values)
    if (is_bad(value) && has_raw(measured, value.raw)) raws.push_back(value.raw);
  std::ranges::sort(raws);
  return raws;
}

void settle(Companion& companion, std::span<const double> seen,
            std::vector<std::string>& warnings) {
  // In the second half of the log every sensor has started.
  std::map<double, std::size_t> counts;
  for (const double value : seen.subspan(seen.size() / 2)) ++counts[value];
  if (counts.empty()) return;
  const auto usual =
      std::ranges::max_element(counts, {}, [](const auto& one) { return one.second; });
  if (!companion.value) {
    companion.value = usual->first;
  } else if (usual->first != *companion.value) {
    warnings.push_back(fmt::format(
        "{} is mostly {:g} in the log, but according to its names {:g} is valid: it is left out",
        companion.signal->name, usual->first, *companion.value));
    companion.value.reset();
  }
}

}  // namespace odomd::tools
