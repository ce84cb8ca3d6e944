#include "can_protocol/decode/name_words.hpp"

#include <cctype>

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

Dimension dimension_of(Unit unit) noexcept {
  switch (unit) {
    case Unit::none:
    case Unit::percent:
      return Dimension::none;
    case Unit::rad:
    case Unit::deg:
      return Dimension::angle;
    case Unit::rad_per_s:
    case Unit::deg_per_s:
      return Dimension::angular_rate;
    case Unit::m_per_s:
    case Unit::km_per_h:
    case Unit::rpm:
    case Unit::erpm:
      return Dimension::speed;
    case Unit::m_per_s2:
    case Unit::g:
      return Dimension::acceleration;
  }
  return Dimension::none;
}

}  // namespace odomd::can
