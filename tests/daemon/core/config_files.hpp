// A configuration file to write and load, with its errors.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/core/config.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon {

inline constexpr auto small_bus = R"(
[can]
dbc = "car.dbc"
[can.signals]
wheel_rear = { message = "WHEEL", signal = "REAR", unit = "m/s" }
)";

class ConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "odomd_config_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = std::filesystem::canonical(name);
    file_ = directory_ / "car.toml";
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  void write(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }

  [[nodiscard]] Config load(const std::string& text) const {
    write(text);
    return load_config(file_);
  }

  /// The error without the directory; empty when there was none.
  [[nodiscard]] std::string error_of(const std::string& text) const {
    write(text);
    return error();
  }
  [[nodiscard]] std::string error() const {
    try {
      static_cast<void>(load_config(file_));
    } catch (const ConfigError& error) {
      std::string what = error.what();
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      const auto prefix = directory_.string() + "/";
      EXPECT_EQ(what.rfind(prefix, 0), 0U) << what;
      return what.substr(prefix.size());
    }
    return "";
  }

  std::filesystem::path directory_;
  std::filesystem::path file_;
};

}  // namespace odomd::daemon
