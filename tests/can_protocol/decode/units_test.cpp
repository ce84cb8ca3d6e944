// Unit texts of databases, and the nearest known names of misspelt ones.
#include "can_protocol/decode/units.hpp"

#include <fstream>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <set>

#include "base/nearest_name.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::units_test {
namespace {

TEST(Units, AreKnownInTheSpellingsOfRealDatabases) {
  const auto expect_unit = [](Unit unit, std::initializer_list<std::string_view> spellings) {
    for (const std::string_view spelling : spellings)
      EXPECT_EQ(unit_of_text(spelling), unit) << spelling;
  };
  expect_unit(Unit::rad, {"rad", "Radians"});
  expect_unit(Unit::deg, {"deg", "°", "º", "degrees", "Degree"});
  expect_unit(Unit::rad_per_s, {"rad/s", "rad/sec", "rad / s", "radians/second"});
  expect_unit(Unit::deg_per_s, {"deg/s", "°/s", "º/s", "degrees/s", "deg/sec", "degrees/second"});
  expect_unit(Unit::m_per_s, {"m/s", "mps", "M/S"});
  expect_unit(Unit::km_per_h, {"km/h", "kph", "KPH", "kmh"});
  expect_unit(Unit::rpm, {"rpm", "1/min", "RPM", "min-1", "min^-1", "U/min"});
  expect_unit(Unit::m_per_s2, {"m/s2", "m/s^2", "m/s²", "m/s^2 ", "m/s/s", "m/(s^2)"});
  expect_unit(Unit::g, {"g", "G", "Unit_ForceOfGravi"});
  expect_unit(Unit::erpm, {"erpm", "ERPM", "eRPM", "erev/min"});
  expect_unit(Unit::percent, {"%", "percent", "Per cent", "pct", "Unit_PerCent"});
  expect_unit(Unit::km_per_h, {"Unit_KiloMeterPerHour", "km per hour", "kilometres/hour"});
  expect_unit(Unit::m_per_s, {"Unit_MeterPerSecon", "Unit_MeterPerSecond", "metre per second"});
  expect_unit(Unit::m_per_s2, {"Unit_MeterPerSeconSquar", "Unit_MeterPerSecondSquared"});
  expect_unit(Unit::deg, {"Unit_DegreOfArc", "Unit_Degree"});
  expect_unit(Unit::deg_per_s, {"Unit_DegreOfArcPerSecon", "Unit_DegreePerSecond"});
  expect_unit(Unit::rad_per_s, {"Unit_RadianPerSecon", "Unit_RadianPerSecond"});
  expect_unit(Unit::rpm, {"Unit_MinutInver", "Unit_RevolutionsPerMinute", "rotations per minute"});
}

// docs/can.md has a table of units; the first cell of a row is the spelling in the configuration.
TEST(Units, AreAllThatThePageLists) {
  std::ifstream page(ODOMD_SOURCE_DIR "/docs/can.md");
  std::string line;
  while (std::getline(page, line) && line != "<!-- units -->") continue;
  std::set<Unit> listed;
  int spellings = 0;
  for (int i = 0; std::getline(page, line) && line.starts_with('|'); ++i) {
    if (i < 2) continue;  // header
    std::optional<Unit> unit;
    for (std::size_t at = line.find('`'); at != std::string::npos; at = line.find('`', at)) {
      const std::size_t end = line.find('`', at + 1);
      ASSERT_NE(end, std::string::npos) << line;
      const std::string spelling = line.substr(at + 1, end - at - 1);
      if (!unit) {
        unit = unit_of_text(spelling);
        ASSERT_TRUE(unit) << line;
        EXPECT_EQ(unit_name(*unit), spelling);
        listed.insert(*unit);
      }
      EXPECT_EQ(unit_of_text(spelling), unit) << spelling;
      ++spellings;
      at = end + 1;
    }
  }
  EXPECT_EQ(listed.size(), static_cast<std::size_t>(Unit::percent));  // all except `none`
  EXPECT_GT(spellings, 40);
}

TEST(Units, AreUnknownWhenTheyAreNoneOfOurs) {
  for (const char* text : {"", "SED", "%/s", "Nm", "Unitless", "V", "m", "s", "mph", "Unit_Liter"})
    EXPECT_EQ(unit_of_text(text), std::nullopt) << text;
}

TEST(Units, AreOthersWhenTheyMeasureSomethingElse) {
  for (const char* text :
       {"mph", "MPH", "mi/h", "%", "Unit_Meter", "mm/s", "mrad", "Nm", "V", "m", "\u00B0C"})
    EXPECT_TRUE(is_other_unit(text)) << text;
  for (const char* text : {"", "SED", "Unitless", "m/s", "km/h", "g", "rpm", "\u00B0"})
    EXPECT_FALSE(is_other_unit(text)) << text;
}

TEST(Units, ConvertToSi) {
  EXPECT_DOUBLE_EQ(si_factor(Unit::deg) * 180.0, std::numbers::pi);
  EXPECT_DOUBLE_EQ(si_factor(Unit::km_per_h) * 3.6, 1.0);
  EXPECT_DOUBLE_EQ(si_factor(Unit::rpm) * 60.0, 2.0 * std::numbers::pi);
  EXPECT_EQ(si_factor(Unit::g), 9.80665);
  for (const Unit unit : {Unit::none, Unit::rad, Unit::rad_per_s, Unit::m_per_s, Unit::m_per_s2})
    EXPECT_EQ(si_factor(unit), 1.0);
}

TEST(Units, HaveNamesThatMeanThem) {
  for (int i = 1; i <= static_cast<int>(Unit::percent); ++i)
    EXPECT_EQ(unit_of_text(unit_name(static_cast<Unit>(i))), static_cast<Unit>(i));
}

TEST(NearestName, DistinguishesATypoFromAnotherWord) {
  EXPECT_TRUE(resembles("profil", "profile"));
  EXPECT_TRUE(resembles("cam", "can"));
  EXPECT_TRUE(resembles("data_idlsit", "data_id_list"));
  EXPECT_FALSE(resembles("sigma", "signal"));
  EXPECT_FALSE(resembles("data_id_mode", "data_id_list"));
  EXPECT_FALSE(resembles("cornering_stiffness_rear", "cornering_stiffness_front"));
}

TEST(NearestName, FindsTheOneWithTheFewestEdits) {
  const std::vector<std::string> names{"WHEEL_FL", "WHEEL_FR", "STEER", "yaw_rate"};
  EXPECT_EQ(nearest_name("WHEEL_FX", names), "WHEEL_FL");  // the first of equally near names
  EXPECT_EQ(nearest_name("WHEL_FR", names), "WHEEL_FR");
  EXPECT_EQ(nearest_name("STERE", names), "STEER");
  EXPECT_EQ(nearest_name("YAW_RATE", names), "yaw_rate");
  EXPECT_EQ(nearest_name("", names), "STEER");
  EXPECT_EQ(nearest_name("x", {}), "");
  EXPECT_EQ(nearest_hint("x", {}), "");
  EXPECT_EQ(nearest_hint("Steer", names), "; the nearest is 'STEER'");
}

TEST(NearestName, IsLikelyWhereItResemblesOrWasCutShort) {
  const std::vector<std::string> names{"plot", "pose", "evaluate"};
  EXPECT_EQ(likely_name("eval", names), "evaluate");
  EXPECT_EQ(likely_name("evalaute", names), "evaluate");
  EXPECT_EQ(likely_name("pos", names), "pose");
  EXPECT_EQ(likely_name("post", names), "pose");
  EXPECT_EQ(likely_name("nonsense", names), "");
  EXPECT_EQ(likely_name("", names), "");
  EXPECT_EQ(likely_name("s", std::vector<std::string>{"seed", "speed"}), "");
  EXPECT_EQ(likely_name("s", std::vector<std::string>{"seed", "laps"}), "seed");
  EXPECT_EQ(likely_name("x", {}), "");
}

}  // namespace
}  // namespace odomd::can::units_test
