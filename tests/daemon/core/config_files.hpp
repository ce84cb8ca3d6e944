// Writes, loads and checks a configuration file.
#pragma once

#include "daemon/core/config.hpp"
#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::daemon {

inline const std::string small_bus = R"(
[can]
dbc = "car.dbc"
[can.signals]
wheel_rear = { message = "WHEEL", signal = "REAR", unit = "m/s" }
)";

class ConfigTest : public testing::Test {
 protected:
  [[nodiscard]] Config load(const std::string& text) const {
    scratch_.write("car.toml", text);
    return load_config(file_);
  }

  /// The warnings of `odomd --check`.
  [[nodiscard]] diagnostics::Diagnostics warnings_of(const std::string& text) const {
    Config config = load(text);
    static_cast<void>(load_databases(config, config.warnings));
    return config.warnings;
  }

  /// The error of loading file and databases, without the directory's path; empty if all is well.
  [[nodiscard]] std::string error_of(const std::string& text) const {
    return in_one_line(message_of([&] { static_cast<void>(warnings_of(text)); }));
  }
  /// The error of loading the file as it is, without its databases.
  [[nodiscard]] std::string error() const {
    return in_one_line(message_of([this] { static_cast<void>(load_config(file_)); }));
  }

  Scratch scratch_;
  std::filesystem::path directory_ = std::filesystem::canonical(scratch_.path(""));
  std::filesystem::path file_ = directory_ / "car.toml";

 private:
  [[nodiscard]] std::string in_one_line(std::string error) const {
    const auto prefix = directory_.string() + "/";
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_TRUE(error.empty() || error.starts_with(prefix)) << error;
    for (std::size_t at = 0; (at = error.find(prefix, at)) != std::string::npos;)
      error.erase(at, prefix.size());
    return error;
  }
};

}  // namespace odomd::daemon
