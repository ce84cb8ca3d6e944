// Files with one row per line, defined by one table of columns: a function that passes the name and
// the value of every column to `cell`, in the order of the file. Header, writer and reader use it.
//
//   inline constexpr auto point_columns = [](auto&& cell, auto& point) {
//     cell("t", point.t_ns);              // std::int64_t: a time, in seconds
//     cell("sigma_", point.sigma_x, "x");  // double; the name may have two parts
//     cell("ticks", point.ticks);         // any other integer, a text, or a Word
//   };
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "tools/cli/csv.hpp"

namespace odomd::tools {

/// An enumerator, written as its name. The error about an unknown word ends with `otherwise`.
template <typename T, typename Names>
struct Word {
  T& value;
  const Names& names;
  std::string_view otherwise;
};
template <typename T, typename Names>
Word(T&, const Names&, std::string_view) -> Word<T, Names>;

template <typename Row>
[[nodiscard]] std::vector<std::string> names_of(const auto& columns) {
  std::vector<std::string> names;
  const auto add = [&names](std::string_view name, const auto&, std::string_view rest = "") {
    names.emplace_back(name).append(rest);
  };
  columns(add, static_cast<const Row&>(Row{}));
  return names;
}

template <typename Row>
[[nodiscard]] std::string header_of(const auto& columns) {
  return joined(names_of<Row>(columns)) + '\n';
}

/// Appends a row with its newline; numbers have `decimals`, or all their digits.
void append_row(std::string& out, const auto& columns, const auto& row, int decimals = all_digits) {
  const auto append = [&](std::string_view, const auto& value, std::string_view = {}) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::int64_t>)
      append_seconds(out, value);
    else if constexpr (std::is_same_v<Value, double>)
      append_number(out, value, decimals);
    else if constexpr (requires { value.names; })
      out += value.names.at(static_cast<std::size_t>(value.value));
    else
      fmt::format_to(std::back_inserter(out), "{}", value);
    out += ',';
  };
  columns(append, row);
  out.back() = '\n';
}

/// The reader's row. `columns` must be the reader's first columns; absent ones keep their defaults.
template <typename Row>
[[nodiscard]] Row read_row(const CsvReader& reader, const auto& columns) {
  Row row{};
  std::size_t column = 0;
  const auto read = [&](std::string_view, auto&& value, std::string_view = {}) {
    using Value = std::remove_cvref_t<decltype(value)>;
    const std::size_t here = column++;
    if (!reader.has(here)) return;
    if constexpr (std::is_same_v<Value, std::int64_t>)
      value = reader.time_ns(here);
    else if constexpr (std::is_same_v<Value, double>)
      value = reader.number(here);
    else if constexpr (requires { value.names; })
      value.value = static_cast<std::remove_cvref_t<decltype(value.value)>>(
          reader.word(here, value.names, value.otherwise));
    else if constexpr (std::is_same_v<Value, std::string>)
      value = reader.text(here);
    else
      value = reader.count<Value>(here);
  };
  columns(read, row);
  return row;
}

}  // namespace odomd::tools
