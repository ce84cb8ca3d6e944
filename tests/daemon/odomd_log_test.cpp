// What the running daemon makes of live pipes whose clock is not right.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "daemon_process.hpp"

namespace odomd::testing::odomd_log_test {
namespace {

using ::testing::HasSubstr;

/// A daemon at a live pipe whose stamps are `clock` of the time since the start [s].
struct LivePipe {
  std::string name;
  std::function<double(double)> clock;
  std::unique_ptr<Desk> desk = std::make_unique<Desk>();
  std::unique_ptr<DaemonProcess> odomd =
      std::make_unique<DaemonProcess>(*desk, std::vector<std::string>{});

  void write(double seconds) const {
    std::string lines;
    int id = 0x100;
    for (const char* data : {"DC050000", "00000000", "0000"}) {
      const auto us = static_cast<std::int64_t>(1e6 * clock(seconds)) + id;
      lines += fmt::format("({}.{:06}) can0 {:X}#{}\n", 1'700'000'000 + us / 1'000'000,
                           us % 1'000'000, id++, data);
    }
    odomd->feed(lines);
  }
  [[nodiscard]] std::uint64_t fused() const {
    const nlohmann::json status = desk->status();
    if (status.is_null()) return 0;
    for (const auto& source : status["sources"])
      if (source["name"] == "wheel_rear") return source["verdicts"]["fused"];
    return 0;
  }
};

TEST(OdomdLogs, LivePipesWhoseClockIsSteppedOrIsSlowAreFollowed) {
  const auto stepped = [](double by) { return [by](double t) { return t < 1.5 ? t : t + by; }; };
  std::vector<LivePipe> pipes;
  pipes.push_back({"right", [](double t) { return t; }});
  pipes.push_back({"a step back of 0.3 s", stepped(-0.3)});
  pipes.push_back({"a step back of 1 s", stepped(-1.0)});
  pipes.push_back({"a step ahead of 0.3 s", stepped(0.3)});
  pipes.push_back({"1 % slow", [](double t) { return 0.99 * t; }});
  pipes.push_back({"1 % fast", [](double t) { return 1.01 * t; }});
  for (const LivePipe& pipe : pipes)
    ASSERT_TRUE(eventually([&] { return !pipe.desk->status().is_null(); })) << pipe.name;
  std::vector<std::uint64_t> before;
  const auto start = std::chrono::steady_clock::now();
  for (int cycle = 0; cycle < 600; ++cycle) {
    std::this_thread::sleep_until(start + std::chrono::milliseconds(10 * cycle));
    for (const LivePipe& pipe : pipes) pipe.write(0.01 * cycle);
    if (cycle == 500)
      for (const LivePipe& pipe : pipes) before.push_back(pipe.fused());
  }
  for (std::size_t i = 0; i < pipes.size(); ++i) {
    EXPECT_GE(pipes[i].fused(), before[i] + 70) << pipes[i].name << pipes[i].desk->read("stderr");
    const auto conditions = pipes[i].desk->status()["conditions"].dump();
    EXPECT_THAT(conditions, ::testing::Not(HasSubstr("signal_timeout"))) << pipes[i].name;
  }
}

}  // namespace
}  // namespace odomd::testing::odomd_log_test
