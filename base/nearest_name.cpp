// Edit distance (optimal string alignment) over names.
#include "base/nearest_name.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace odomd {
namespace {

constexpr int whole_edit = 10;
constexpr int case_edit = 1;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

int replace_cost(char a, char b) {
  if (a == b) return 0;
  return lower(a) == lower(b) ? case_edit : whole_edit;
}

// Only this many characters are compared: the input may be a whole file.
constexpr std::size_t longest_name = 64;

int edit_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, longest_name);
  b = b.substr(0, longest_name);
  // Three rows of the table: two[j], one[j] and row[j] are the distances between the first i-2, i-1
  // and i characters of a and the first j of b.
  std::vector<int> two(b.size() + 1);
  std::vector<int> one(b.size() + 1);
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j) * whole_edit;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    two.swap(one);
    one.swap(row);
    row[0] = static_cast<int>(i) * whole_edit;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({one[j] + whole_edit, row[j - 1] + whole_edit,
                         one[j - 1] + replace_cost(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], two[j - 2] + whole_edit);
    }
  }
  return row[b.size()];
}

}  // namespace

std::string_view nearest_name(std::string_view wanted, std::span<const std::string> names) {
  const auto nearest =
      std::min_element(names.begin(), names.end(), [wanted](const auto& a, const auto& b) {
        return edit_distance(wanted, a) < edit_distance(wanted, b);
      });
  return nearest == names.end() ? std::string_view{} : std::string_view{*nearest};
}

bool resembles(std::string_view a, std::string_view b) {
  const int edits = std::min(a.size(), b.size()) < 8 ? 1 : 2;
  return edit_distance(a, b) <= edits * whole_edit;
}

std::string_view likely_name(std::string_view given, std::span<const std::string> names) {
  if (given.empty()) return {};
  const auto begun = [given](const std::string& name) { return name.starts_with(given); };
  const auto longer = std::find_if(names.begin(), names.end(), begun);
  constexpr std::size_t distinctive = 3;  // letters
  if (longer != names.end() &&
      (given.size() >= distinctive || std::none_of(longer + 1, names.end(), begun)))
    return *longer;
  const std::string_view nearest = nearest_name(given, names);
  return resembles(given, nearest) ? nearest : std::string_view{};
}

std::string nearest_hint(std::string_view wanted, std::span<const std::string> names) {
  if (names.empty()) return {};
  return std::string("; the nearest is '").append(nearest_name(wanted, names)).append("'");
}

}  // namespace odomd
