// Asks the daemon's status socket: whoever connects is sent one JSON document.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace odomd::tools {

/// The document as it came. Throws std::invalid_argument for a path that cannot be a socket's,
/// std::runtime_error where nobody answers in time.
[[nodiscard]] std::string fetch_status(const std::filesystem::path& socket,
                                       std::chrono::milliseconds timeout = std::chrono::seconds{2});

/// The document as an object. Throws std::runtime_error, which names the socket, where the answer
/// is something else.
[[nodiscard]] nlohmann::json parse_status(const std::string& document,
                                          const std::filesystem::path& socket);

}  // namespace odomd::tools
