// The lists of a status document as tables, for odom status and odom watch.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/live/line.hpp"
#include "tools/live/status_value.hpp"

namespace odomd::tools {

struct Column {
  std::string title;
  std::function<Span(const StatusValue& row)> cell;
  bool flush_left = false;
};

/// A column with the value at `path` of each row.
[[nodiscard]] Column column(std::string title, std::string path,
                            std::string (StatusValue::*in_words)() const = &StatusValue::text);
[[nodiscard]] Column left(Column column);

/// Cells line up, with two blanks in between, and the titles above them unless all are empty. No
/// lines if there are no rows.
[[nodiscard]] Lines table_of(const std::vector<Column>& columns,
                             const std::vector<StatusValue>& rows);

/// All columns for odom status, or those for which a screen has room.
enum class Form { whole, wide_screen, screen };

[[nodiscard]] Lines source_table(const StatusValue& status, Form form);
[[nodiscard]] Lines message_table(const StatusValue& status, Form form);
/// The calibrations that the model estimates.
[[nodiscard]] Lines calibration_table(const StatusValue& status, Form form, Glyphs glyphs);

}  // namespace odomd::tools
