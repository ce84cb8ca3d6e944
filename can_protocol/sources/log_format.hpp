// Recognises the files of other tools that are given in place of a candump log.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace odomd::can {

/// Describes a file by its first bytes, and how to convert it to a candump log: "is a Vector ASC
/// log, not a candump log; ..."; empty for a candump log and for anything unknown.
[[nodiscard]] std::optional<std::string> describe_foreign_format(std::string_view start);

}  // namespace odomd::can
