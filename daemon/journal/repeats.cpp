#include "daemon/journal/repeats.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "base/seconds.hpp"

namespace odomd::daemon {
namespace {

bool is_number(std::string_view word) {
  constexpr std::string_view around = "([{+=,;:.)]}%";
  const std::size_t begin = word.find_first_not_of(around);
  if (begin == std::string_view::npos) return false;
  const std::size_t end = word.find_last_not_of(around) + 1;
  double value = 0.0;
  const auto [after, error] = std::from_chars(word.data() + begin, word.data() + end, value);
  return error == std::errc{} && after == word.data() + end;
}

/// The text without its numbers.
std::string kind_of(std::string_view text) {
  std::string kind;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    if (!is_number(word)) kind.append(word) += ' ';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return kind;
}

}  // namespace

bool Repeats::take(const Message& message, std::int64_t now_ns) {
  const auto [at, is_new] = repetitions_.try_emplace(kind_of(message.text));
  Repetition& repetition = at->second;
  if (is_new) {
    repetition.logged_ns = repetition.newest_ns = now_ns;
    return true;
  }
  repetition.newest_ns = now_ns;
  if (repetition.counted == 0 && now_ns - repetition.logged_ns >= repetition.interval_ns) {
    repetition.logged_ns = now_ns;
    repetition.interval_ns = std::min(4 * repetition.interval_ns, longest_interval_ns);
    return true;
  }
  repetition.newest = message;
  ++repetition.counted;
  return false;
}

std::vector<Message> Repeats::due(std::int64_t now_ns) {
  std::vector<Message> messages;
  for (auto& [kind, repetition] : repetitions_)
    if (repetition.counted > 0 && now_ns - repetition.logged_ns >= repetition.interval_ns)
      messages.push_back(sum_of(repetition, now_ns));
  std::erase_if(repetitions_, [now_ns](const auto& entry) {
    const Repetition& repetition = entry.second;
    return repetition.counted == 0 && now_ns - repetition.newest_ns >= longest_interval_ns;
  });
  return messages;
}

std::vector<Message> Repeats::rest(std::int64_t now_ns) {
  std::vector<Message> messages;
  for (auto& [kind, repetition] : repetitions_)
    if (repetition.counted > 0) messages.push_back(sum_of(repetition, now_ns));
  return messages;
}

Message Repeats::sum_of(Repetition& repetition, std::int64_t now_ns) {
  std::string sum = fmt::format("{} ({} {} in {:.3g} s", repetition.newest.text, repetition.counted,
                                repetition.counted == 1 ? "time" : "times",
                                seconds(now_ns - repetition.logged_ns));
  const double ago_s = seconds(now_ns - repetition.newest_ns);
  if (ago_s >= 1.0) sum += fmt::format(", the last {:.3g} s ago", ago_s);
  const spdlog::level::level_enum level = repetition.newest.level;
  repetition.logged_ns = now_ns;
  repetition.interval_ns = std::min(4 * repetition.interval_ns, longest_interval_ns);
  repetition.counted = 0;
  return {level, std::move(sum) + ")"};
}

}  // namespace odomd::daemon
