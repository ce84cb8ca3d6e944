// Unit texts of databases, and the nearest known names of misspelt ones.
#include "can_protocol/decode/units.hpp"

#include <fstream>
#include <optional>
#include <set>
#include <tuple>

#include "base/nearest_name.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::units_test {
namespace {

// The spellings in docs/can.md are tested below.
TEST(Units, AreKnownInOtherSpellingsOfRealDatabases) {
  const std::pair<Unit, std::vector<std::string_view>> units[]{
      {Unit::rad, {"Radians"}},
      {Unit::deg, {"º", "Degree", "Unit_Degree"}},
      {Unit::rad_per_s, {"rad/sec", "rad / s", "Unit_RadianPerSecon", "Unit_RadianPerSecond"}},
      {Unit::deg_per_s, {"º/s", "degrees/s", "deg/sec", "Unit_DegreePerSecond"}},
      {Unit::m_per_s, {"M/S", "Unit_MeterPerSecond", "metre per second"}},
      {Unit::km_per_h, {"KPH", "km per hour", "kilometres/hour"}},
      {Unit::rpm, {"RPM", "min-1", "Unit_RevolutionsPerMinute", "rotations per minute"}},
      {Unit::m_per_s2, {"m/s^2", "m/s^2 ", "m/(s^2)", "Unit_MeterPerSecondSquared"}},
      {Unit::g, {"G"}},
      {Unit::erpm, {"ERPM", "eRPM"}},
      {Unit::percent, {"Per cent"}},
  };
  for (const auto& [unit, spellings] : units)
    for (const std::string_view spelling : spellings)
      EXPECT_EQ(unit_of_text(spelling), unit) << spelling;
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

TEST(Units, AreUnknownIfNoRoleAcceptsThem) {
  for (const char* text : {"", "SED", "%/s", "Nm", "Unitless", "V", "m", "s", "mph", "Unit_Liter"})
    EXPECT_EQ(unit_of_text(text), std::nullopt) << text;
  // Some of these texts are units of other quantities.
  for (const char* text :
       {"mph", "MPH", "mi/h", "%", "Unit_Meter", "mm/s", "mrad", "Nm", "V", "m", "\u00B0C"})
    EXPECT_TRUE(is_other_unit(text)) << text;
  for (const char* text : {"", "SED", "Unitless", "m/s", "km/h", "g", "rpm", "\u00B0"})
    EXPECT_FALSE(is_other_unit(text)) << text;
}

TEST(NearestName, DistinguishesATypoFromAnotherWord) {
  for (const auto& [typo, name, alike] :
       {std::tuple{"profil", "profile", true},
        {"cam", "can", true},
        {"data_idlsit", "data_id_list", true},
        {"sigma", "signal", false},
        {"data_id_mode", "data_id_list", false},
        {"cornering_stiffness_rear", "cornering_stiffness_front", false}})
    EXPECT_EQ(resembles(typo, name), alike) << typo;
}

TEST(NearestName, FindsTheNameWithTheFewestEdits) {
  const std::vector<std::string> names{"WHEEL_FL", "WHEEL_FR", "STEER", "yaw_rate"};
  for (const auto& [name, nearest] : {std::pair{"WHEEL_FX", "WHEEL_FL"},  // the first of equals
                                      {"WHEL_FR", "WHEEL_FR"},
                                      {"STERE", "STEER"},
                                      {"YAW_RATE", "yaw_rate"},
                                      {"", "STEER"}})
    EXPECT_EQ(nearest_name(name, names), nearest);
  EXPECT_EQ(nearest_name("x", {}), "");
  EXPECT_EQ(nearest_hint("x", {}), "");
  EXPECT_EQ(nearest_hint("Steer", names), "; the nearest is 'STEER'");
}

TEST(NearestName, IsLikelyIfSimilarOrAbbreviated) {
  const std::vector<std::string> names{"plot", "pose", "evaluate", "seed", "speed"};
  for (const auto& [name, likely] : {std::pair{"eval", "evaluate"},
                                     {"evalaute", "evaluate"},
                                     {"pos", "pose"},
                                     {"post", "pose"},
                                     {"nonsense", ""},
                                     {"", ""},
                                     {"s", ""},  // seed or speed
                                     {"se", "seed"}})
    EXPECT_EQ(likely_name(name, names), likely) << name;
  EXPECT_EQ(likely_name("x", {}), "");
}

}  // namespace
}  // namespace odomd::can::units_test
