// Logs that are out of order, in the running daemon compared with a replay.
#include <fmt/format.h>

#include <map>
#include <sstream>

#include "daemon_process.hpp"

namespace odomd::testing::odomd_log_test {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A drive of a second, with `extra` inserted before its line `at`.
std::string drive_with(const std::string& extra, std::size_t at = 150) {
  std::string log;
  const auto lines = lines_of(straight_drive(1.0, 1.5));
  for (std::size_t i = 0; i < lines.size(); ++i) log += (i == at ? extra : "") + lines[i] + '\n';
  return log;
}

/// The same drive; each line is followed by an unmapped frame whose clock is `hours` ahead.
std::string drive_beside(int hours) {
  std::string log;
  int i = 0;
  for (const std::string& line : lines_of(straight_drive(1.0, 1.5)))
    log +=
        line + fmt::format("\n({}.{:06}) can0 7A2#00\n", 1'700'000'000 + 3600 * hours, ++i * 3000);
  return log;
}

using Verdicts = std::map<std::string, nlohmann::json>;

Verdicts replayed(const Desk& desk) {
  EXPECT_EQ(
      desk.odom("replay --json --config car.toml --can drive.log --out replay.csv", "replay.json"),
      0)
      << desk.read("replay.json");
  const auto summary = nlohmann::json::parse(desk.read("replay.json"));
  EXPECT_LT(summary["drive_s"], 1.1);
  return summary["verdicts"];
}

Verdicts played(const Desk& desk) {
  const DaemonProcess odomd(desk, {"--can", desk.file("drive.log")});
  auto status = desk.await_status([](auto& now) { return now["can"][0]["link"] == "ended"; });
  Verdicts verdicts;
  for (const auto& source : status["sources"])
    for (const auto& [verdict, count] : source["verdicts"].items())
      if (count != 0) verdicts[source["name"]][verdict] = count;
  return verdicts;
}

TEST(OdomdLogs, AreUsedAsAReplayUsesThem) {
  const std::pair<std::string, std::string> logs[]{
      {"dropped", drive_with("DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n")},
      {"edited", "\xEF\xBB\xBF# lap 3, wet\n" + drive_with("")},
      {"joined", drive_with(std::string(40, '\0') + "\n(1700000000.499\n")},
      {"CAN XL", drive_with("(1700000000.499) can0 45123#81:00:12345678#11223344\n")},
      {"unmapped, once", drive_with("(1700000010.500000) can0 7A2#00\n")},
      {"unmapped first", drive_with("(1800000000.500000) can0 7A2#00\n", 0)},
      {"unmapped, ahead", drive_beside(2)},
      {"unmapped, behind", drive_beside(-2)},
      {"mapped, ahead", drive_with("(1700000010.500000) can0 100#DC050000\n")},
      {"mapped, behind", drive_with("(1699999990.500000) can0 100#DC050000\n")},
      {"mapped, twice", drive_with("(1700000010.500000) can0 100#DC050000\n"
                                   "(1700000010.500100) can0 101#00000000\n")},
  };
  const Verdicts sound = [] {
    const Desk desk;
    desk.write("drive.log", drive_with(""));
    return replayed(desk);
  }();
  EXPECT_EQ(sound.at("wheel_rear"), (nlohmann::json{{"fused", 100}}));
  for (const auto& [name, log] : logs) {
    Verdicts live;
    // On a machine under load, frames may arrive after their tick.
    for (int attempt = 0; attempt < 5 && live != sound; ++attempt) {
      const Desk desk;
      desk.write("drive.log", log);
      EXPECT_EQ(replayed(desk), sound) << name;
      live = played(desk);
      // Left-out frames of mapped messages are reported live, too.
      EXPECT_EQ(desk.read("stderr").find("far from those around") != std::string::npos,
                name.starts_with("mapped"))
          << name;
    }
    EXPECT_EQ(live, sound) << name;
  }
}

}  // namespace
}  // namespace odomd::testing::odomd_log_test
