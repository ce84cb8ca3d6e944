// Writes and loads a configuration file, and returns its error.
#pragma once

#include "daemon/core/config.hpp"
#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::daemon {

inline constexpr auto small_bus = R"(
[can]
dbc = "car.dbc"
[can.signals]
wheel_rear = { message = "WHEEL", signal = "REAR", unit = "m/s" }
)";

class ConfigTest : public testing::Test {
 protected:
  void write(const std::string& text) const { scratch_.write("car.toml", text); }

  [[nodiscard]] Config load(const std::string& text) const {
    write(text);
    return load_config(file_);
  }

  /// The error without the directory; empty if there is none.
  [[nodiscard]] std::string error_of(const std::string& text) const {
    write(text);
    return error();
  }
  [[nodiscard]] std::string error() const {
    const std::string what = message_of([this] { static_cast<void>(load_config(file_)); });
    if (what.empty()) return "";
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    const auto prefix = directory_.string() + "/";
    EXPECT_THAT(what, StartsWith(prefix));
    return what.substr(std::min(prefix.size(), what.size()));
  }

  Scratch scratch_;
  std::filesystem::path directory_ = std::filesystem::canonical(scratch_.path(""));
  std::filesystem::path file_ = directory_ / "car.toml";
};

}  // namespace odomd::daemon
