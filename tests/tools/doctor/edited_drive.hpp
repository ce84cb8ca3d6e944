// A drive of `odom sim` with edits of its car.toml, and what the doctor finds in it.
#pragma once

#include <map>

#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/doctor/drive.hpp"

namespace odomd::tools::doctor::edited_drive {

using diagnostics::Diagnostics;
using diagnostics::Named;
using diagnostics::text_of;
using ::testing::Each;

inline constexpr auto slalom = "--scenario slalom --duration 22";

/// A drive of `odom sim` with these options, simulated once.
inline const Scratch& simulated(const std::string& options) {
  static std::map<std::string, Scratch> made;
  const auto [place, is_new] = made.try_emplace(options);
  if (is_new) {
    must_run("odom sim " + options + " --out " + place->second.path("drive").string());
  }
  return place->second;
}

/// A replacement of all occurrences in car.toml.
struct Edit {
  std::string from, to;
};

inline std::string edited(std::string text, const Edit& edit) {
  std::size_t at = text.find(edit.from);
  EXPECT_NE(at, std::string::npos) << edit.from;
  for (; at != std::string::npos; at = text.find(edit.from, at + edit.to.size()))
    text.replace(at, edit.from.size(), edit.to);
  return text;
}

inline Drive drive_with(const std::vector<Edit>& edits, const std::string& options = slalom) {
  const Scratch& scratch = simulated(options);
  std::string text = contents(scratch.path("drive") / "car.toml");
  for (const Edit& edit : edits) text = edited(std::move(text), edit);
  return read_drive(
      {.folder = scratch.path("drive"), .config = scratch.write("drive/edited.toml", text)});
}

inline std::vector<Edit> exchange(const std::string& one, const std::string& other) {
  return {{one, "EXCHANGED"}, {other, one}, {"EXCHANGED", other}};
}

inline Diagnostics found_in(const Drive& drive) {
  return examine_drive(drive).diagnostics;
}

/// All findings are of one kind, and the first names this part of the file.
inline void expect_only(const Diagnostics& found, const std::string& name, const std::string& key) {
  ASSERT_THAT(found, Not(IsEmpty()));
  EXPECT_THAT(found, Each(Named(name)));
  EXPECT_THAT(text_of(found[0]), HasSubstr(key));
}

inline const std::string gyro = R"("YawRate", unit = "rad/s")";
inline const std::string steering = R"("SteeringAngle", unit = "rad")";
inline const std::string speed = R"(unit = "m/s",)";

}  // namespace odomd::tools::doctor::edited_drive
