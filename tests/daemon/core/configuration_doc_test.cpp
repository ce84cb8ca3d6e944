// docs/configuration.md matches the code: its examples load, its errors are the real ones, and its
// tables list the existing keys. Comments in the page mark the checked parts.
#include <fmt/format.h>

#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <type_traits>
#include <variant>

#include "can_protocol/decode/units.hpp"
#include "config_files.hpp"
#include "daemon/core/config_keys.hpp"

namespace odomd::daemon::configuration_doc_test {
namespace {

using testing::UnorderedElementsAreArray;
using Row = std::vector<std::string>;

const std::string& page() {
  static const std::string text = contents(ODOMD_SOURCE_DIR "/docs/configuration.md");
  return text;
}

/// The first group of each match.
std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
  return {std::sregex_token_iterator(text.begin(), text.end(), pattern, 1), {}};
}

/// The texts after <!-- KIND: LABEL -->, up to the next such mark, by label.
std::multimap<std::string, std::string> marked(const std::string& kind) {
  std::multimap<std::string, std::string> found;
  const std::string opening = "<!-- " + kind;
  for (auto at = page().find(opening); at != std::string::npos; at = page().find(opening, at + 1)) {
    const auto end = page().find(" -->", at);
    std::string label = page().substr(at + opening.size(), end - at - opening.size());
    label.erase(0, label.starts_with(": ") ? 2 : 0);
    const auto begin = page().find('\n', end) + 1;
    found.emplace(label, page().substr(begin, page().find("<!-- ", begin) - begin));
  }
  return found;
}

/// The ```toml block at the start of `text`.
std::string code(const std::string& text) {
  return text.starts_with("```toml\n") ? text.substr(8, text.find("```", 8) - 8) : "";
}

/// The table at the start of `text`, without its header.
std::vector<Row> rows(const std::string& text) {
  std::vector<Row> all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && line.starts_with("|");) {
    Row& row = all.emplace_back();
    std::istringstream cells(line.substr(2));
    for (std::string cell; std::getline(cells, cell, '|');)
      row.push_back(cell.substr(0, cell.find_last_not_of(' ') + 1).erase(0, row.empty() ? 0 : 1));
  }
  all.erase(all.begin(), all.begin() + std::min<std::ptrdiff_t>(2, std::ssize(all)));
  return all;
}

/// The texts between backticks.
std::vector<std::string> quoted(const std::string& cell) {
  return matches(cell, std::regex("`([^`]*)`"));
}

/// The keys that the page lists, by table.
std::map<std::string, std::vector<std::string>> listed_keys() {
  std::map<std::string, std::vector<std::string>> all;
  for (const auto& [table, text] : marked("keys"))
    for (const Row& row : rows(text))
      for (const auto& key : quoted(row.at(0))) all[table].push_back(key);
  return all;
}

/// The default of each key in the table at the start of `text`; empty if the table has no such
/// column.
std::map<std::string, std::string> listed_defaults(const std::string& text) {
  std::map<std::string, std::string> all;
  if (!text.starts_with("| key | default |")) return all;
  for (const Row& row : rows(text))
    for (const auto& key : quoted(row.at(0))) all[key] = row.at(1);
  return all;
}

std::string example() {
  const auto examples = marked("example");
  return examples.size() == 1 ? code(examples.begin()->second) : "";
}

class ConfigurationPage : public ConfigTest {
 protected:
  ConfigurationPage() {
    scratch_.write("odomd.dbc", contents(ODOMD_SOURCE_DIR "/can_protocol/odomd.dbc"));
  }
};

/// Whether a key has the same value in both configurations.
struct AreEqual {
  Config one, other;
  template <typename Value>
  bool operator()(Member<Value> member) {
    if constexpr (std::is_same_v<Value, std::optional<estimator::Pose2>>)
      return member(one).has_value() == member(other).has_value();
    else
      return member(one) == member(other);
  }
  bool operator()(const auto& /*unused*/) { return true; }  // no value
};

TEST_F(ConfigurationPage, ItsExampleIsAcceptedAndHasTheReferenceCar) {
  ASSERT_FALSE(example().empty());
  EXPECT_THAT(warnings_of(example()), IsEmpty());
  const Config shown = load(example()), taken = load(small_bus);
  for (const ConfigKey& key : config_keys())
    EXPECT_TRUE(key.table != "vehicle" || std::visit(AreEqual{shown, taken}, key.member))
        << key.name;
}

/// A configuration with the defaults of the tables, as far as they are values.
std::string tabulated_configuration() {
  const std::map<std::string, std::string> begins = {
      {"can", "[can]\ndbc = 'a.dbc'\n"},
      {"can.e2e.MESSAGE", "[can.e2e.M]\nprofile = 'P01'\ndata_id = 1\ncrc = 'C'\ncounter = 'K'\n"},
      {"can.signals.ROLE",
       "[can.signals.wheel_rear]\nmessage = 'M'\nsignal = 'S'\nunit = 'rpm'\nradius = 1\n"}};
  std::string all;
  for (const auto& [table, text] : marked("keys")) {
    std::string values;
    for (const auto& [key, cell] : listed_defaults(text)) {
      const auto value = std::regex_replace(cell, std::regex("`"), "");
      if (std::regex_search(value, std::regex(R"(^[-0-9"\[])")))
        values += key + " = " + value + '\n';
    }
    if (values.empty()) continue;
    const auto begin = begins.find(table);
    all += (begin == begins.end() ? '[' + table + "]\n" : begin->second) + values;
  }
  return all;
}

TEST_F(ConfigurationPage, ItsTablesHaveTheDefaults) {
  const std::string text = tabulated_configuration();
  EXPECT_EQ(std::count(text.begin(), text.end(), '='), 9 + 39) << text;
  Config shown = load(text), taken = load(small_bus);
  for (Config* const config : {&shown, &taken}) place_sockets(*config, "/run/odomd");
  for (const ConfigKey& key : config_keys())
    EXPECT_TRUE(std::visit(AreEqual{shown, taken}, key.member)) << key.table << '.' << key.name;
  EXPECT_EQ(shown.can.timestamps, taken.can.timestamps);
  EXPECT_EQ(shown.log.level, taken.log.level);
  EXPECT_EQ(shown.can.protections.at(0).max_delta_counter, can::E2eBinding{}.max_delta_counter);
  EXPECT_EQ(shown.can.protections.at(0).data_id_mode, can::E2eBinding{}.data_id_mode);
  const auto& role = shown.can.bindings.at(0);
  EXPECT_EQ(role.scale, can::SignalBinding{}.scale);
  EXPECT_EQ(role.offset, can::SignalBinding{}.offset);
  EXPECT_EQ(role.ratio, can::SignalBinding{}.ratio);
  EXPECT_EQ(role.latency_ns, can::SignalBinding{}.latency_ns);
}

constexpr auto powertrain_dbc = R"(VERSION ""
BU_: CAR
BO_ 256 ESC_WHEELS: 8 CAR
 SG_ CHECKSUM : 0|8@1+ (1,0) [0|0] "" CAR
 SG_ COUNTER : 8|4@1+ (1,0) [0|0] "" CAR
 SG_ RL_FAULT : 12|1@1+ (1,0) [0|0] "" CAR
 SG_ RR_FAULT : 13|1@1+ (1,0) [0|0] "" CAR
 SG_ RL : 16|16@1+ (0.01,0) [0|0] "km/h" CAR
 SG_ RR : 32|16@1+ (0.01,0) [0|0] "km/h" CAR
BO_ 257 GEARBOX: 1 CAR
 SG_ LEVER : 0|4@1+ (1,0) [0|0] "" CAR
)";
constexpr auto chassis_dbc = R"(VERSION ""
BU_: CAR
BO_ 300 GYRO: 8 CAR
 SG_ GYRO_CRC : 0|8@1+ (1,0) [0|0] "" CAR
 SG_ GYRO_BZ : 8|4@1+ (1,0) [0|0] "" CAR
 SG_ YAW : 16|16@1- (0.01,0) [0|0] "deg/s" CAR
 SG_ LONG_ACC : 32|16@1- (0.001,0) [0|0] "g" CAR
BO_ 301 STEER_SENSOR: 4 CAR
 SG_ ANGLE : 0|16@1- (1.5,0) [0|0] "deg" CAR
 SG_ ANGLE_FRACTION : 16|4@1- (0.1,0) [0|0] "deg" CAR
)";

TEST_F(ConfigurationPage, ItsRecipesAreAccepted) {
  scratch_.write("powertrain.dbc", powertrain_dbc);
  scratch_.write("chassis.dbc", chassis_dbc);
  const auto recipes = marked("recipe");
  EXPECT_EQ(recipes.size(), 1U);
  for (const auto& [name, text] : recipes) {
    ASSERT_FALSE(code(text).empty()) << name;
    EXPECT_EQ(error_of(code(text)), "") << name;
  }
}

TEST_F(ConfigurationPage, ItsErrorsAreTheRealOnes) {
  const auto errors = marked("error");
  EXPECT_EQ(errors.size(), 2U);
  for (const auto& [mistake, text] : errors) {
    const auto arrow = mistake.find(" -> ");
    ASSERT_NE(arrow, std::string::npos) << mistake;
    std::string mistaken = example();
    const auto at = mistaken.find(mistake.substr(0, arrow));
    ASSERT_NE(at, std::string::npos) << mistake;
    mistaken.replace(at, arrow, mistake.substr(arrow + 4));
    const auto error =
        std::regex_replace(text.substr(0, text.find('\n')), std::regex("/etc/odomd/"), "");
    EXPECT_EQ(error, "    odomd: " + error_of(mistaken));
  }
}

/// The keys that a file of the daemon reads by their names.
std::set<std::string> keys_read_by(const std::string& file) {
  const auto source = contents(ODOMD_SOURCE_DIR "/daemon/core/" + file);
  const auto keys =
      matches(source, std::regex(R"re(\b(?:read\w*|require|tables?|has)\("([a-z_0-9]+)")re"));
  return {keys.begin(), keys.end()};
}

TEST_F(ConfigurationPage, ListsTheKeysThatTheCodeReads) {
  std::map<std::string, std::vector<std::string>> keys;
  for (const ConfigKey& key : config_keys()) keys[std::string(key.table)].emplace_back(key.name);
  auto listed = listed_keys();
  EXPECT_THAT(listed.at("can.signals.ROLE.sign"), UnorderedElementsAre("signal", "negative"));
  EXPECT_THAT(listed.at("can.signals.ROLE.valid_when"),
              UnorderedElementsAre("signal", "equals", "not_equals", "below", "at_least"));
  EXPECT_THAT(listed.at("can"), UnorderedElementsAre("source", "dbc", "timestamps",
                                                     "receive_buffer", "e2e", "signals"));
  EXPECT_EQ(listed.size(), keys.size() + 4) << "sections of [can] are not in the table of keys";
  const auto take = [&](std::initializer_list<std::string> tables) {
    std::set<std::string> all;
    for (const auto& table : tables) {
      const auto& names = listed.at(table);
      all.insert(names.begin(), names.end());
      listed.erase(table);
    }
    return all;
  };
  auto of_the_bus = keys_read_by("config_can.cpp"), of_signals = keys_read_by("config_signal.cpp");
  of_the_bus.insert(keys.at("can").begin(), keys.at("can").end());
  of_signals.insert(can::comparison_names.begin(), can::comparison_names.end());
  EXPECT_EQ(take({"can", "can.e2e.MESSAGE"}), of_the_bus);
  EXPECT_EQ(take({"can.signals.ROLE", "can.signals.ROLE.sign", "can.signals.ROLE.valid_when"}),
            of_signals);
  for (const auto& [table, names] : listed)
    EXPECT_THAT(names, UnorderedElementsAreArray(keys[table])) << table;
}

// A table cell as in the manual page: without formatting and links.
std::string plain(std::string cell) {
  cell = std::regex_replace(cell, std::regex(R"(\[([^\]]*)\]\([^)]*\))"), "$1");
  return std::regex_replace(cell, std::regex("`|\\*\\*"), "");
}

/// The items of the manual page by table and key, each text in one line.
std::map<std::string, std::map<std::string, std::string>> manual_items() {
  std::map<std::string, std::map<std::string, std::string>> all;
  std::istringstream lines(contents(ODOMD_SOURCE_DIR "/man/odomd.toml.5"));
  std::string table;
  std::string* item = nullptr;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(".Ss [")) {
      table = std::regex_replace(line.substr(5), std::regex("\\]"), "");
      table = std::regex_replace(table, std::regex(" "), ".");
    }
    if (line.starts_with(".It Ic ")) {
      item = &all[table][line.substr(7)];
    } else if (line.starts_with(".El") || line.starts_with(".It Cm ")) {
      item = nullptr;
    } else if (item != nullptr) {
      *item += (item->empty() ? "" : " ") + std::regex_replace(line, std::regex(R"(\\-)"), "-");
    }
  }
  return all;
}

TEST_F(ConfigurationPage, HasTheKeysAndDefaultsOfTheManualPage) {
  const auto manual = manual_items();
  const auto listed = listed_keys();
  ASSERT_EQ(manual.size(), listed.size());
  for (const auto& [table, text] : marked("keys")) {
    SCOPED_TRACE(table);
    ASSERT_TRUE(manual.contains(table));
    const auto& items = manual.at(table);
    EXPECT_EQ(items.size(), listed.at(table).size());
    for (const auto& key : listed.at(table)) EXPECT_TRUE(items.contains(key)) << key;
    for (const auto& [key, cell] : listed_defaults(text))
      if (items.contains(key)) {
        EXPECT_THAT(items.at(key), HasSubstr(plain(cell))) << key;
      }
  }
}

TEST_F(ConfigurationPage, ListsTheRolesWithTheirUnitsAndSigmas) {
  const auto tables = marked("roles");
  ASSERT_EQ(tables.size(), 1U);
  std::vector<std::string> roles;
  for (const Row& row : rows(tables.begin()->second)) {
    const auto units = quoted(row.at(2));
    std::vector<std::string> endings;
    for (const auto& unit : units) {
      const bool rolls = units.size() > 2 && can::is_rotation(can::unit_of_text(unit).value());
      endings.push_back(fmt::format("unit = '{}'{}{}", unit, rolls ? ", radius = 1.0" : "",
                                    unit == "erpm" ? ", pole_pairs = 7" : ""));
    }
    if (endings.empty()) endings = {"forward = 1, reverse = 2"};
    for (const auto& role : quoted(row.at(0))) {
      roles.push_back(role);
      for (const auto& ending : endings) {
        const Config config = load(fmt::format(
            "can = {{ dbc = 'a.dbc', signals.{} = {{ message = 'M', signal = 'S', {} }} }}", role,
            ending));
        EXPECT_EQ(config.can.signals.at(config.can.bindings.at(0).channel).sigma,
                  std::stod(row.at(3)))
            << role << ": " << ending;
      }
    }
  }
  std::vector<std::string> known(estimator::source_names.begin(), estimator::source_names.end());
  std::erase(known, "camera");
  EXPECT_EQ(roles, known);
}

TEST_F(ConfigurationPage, NamesEveryModel) {
  for (const auto name : estimator::model_names)
    EXPECT_THAT(page(), HasSubstr("`" + std::string(name) + "`"));
}

}  // namespace
}  // namespace odomd::daemon::configuration_doc_test
