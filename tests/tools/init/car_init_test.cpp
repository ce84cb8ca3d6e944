// odom init as a command, and the numbers of the car that it needs.
#include "tests/tools/scratch.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools::car_init_test {
namespace {

using estimator::Source;
using nlohmann::json;

TEST(Car, RequiresOnlyTheNumbersThatARoleNeeds) {
  const auto needed = [](const Proposal& proposal) {
    std::string options;
    for (const std::string& option : missing_numbers({}, proposal)) options += option + ' ';
    return options;
  };
  const auto mapped = [](Source role, can::Unit unit) {
    Proposal proposal;
    Choice& choice = proposal.of(role).emplace();
    choice.candidate.role = role;
    choice.candidate.unit = unit;
    choice.warnings.emplace_back("not compared");
    return proposal;
  };
  const std::string sizes = "--mass --wheelbase ";
  Proposal wheels = mapped(Source::wheel_rear_left, can::Unit::rad_per_s);
  EXPECT_EQ(needed(wheels), sizes + "--wheel-radius ");
  wheels.of(Source::wheel_rear_right) = wheels.of(Source::wheel_rear_left);
  EXPECT_EQ(needed(wheels), sizes + "--track --wheel-radius ");
  wheels.measured_track = 1.5;
  EXPECT_EQ(needed(wheels), sizes + "--wheel-radius ");
  EXPECT_EQ(needed(mapped(Source::motor, can::Unit::m_per_s)), sizes);
  EXPECT_EQ(needed(mapped(Source::motor, can::Unit::rpm)), sizes + "--wheel-radius --gear-ratio ");
  EXPECT_EQ(needed(mapped(Source::motor, can::Unit::erpm)),
            sizes + "--wheel-radius --gear-ratio --pole-pairs ");
  EXPECT_EQ(needed(mapped(Source::steering, can::Unit::deg)), sizes);  // the ratio is optional
  Proposal command = mapped(Source::steering, can::Unit::none);
  EXPECT_EQ(needed(command), sizes + "--full-lock ");
  command.of(Source::steering)->scale_fits = true;
  EXPECT_EQ(needed(command), sizes);
  const Car known = parse_car({.mass = "3kg", .wheelbase = "260mm"});
  EXPECT_EQ(known.wheelbase, 0.26);
  EXPECT_THAT(missing_numbers(known, {}), IsEmpty());
  // An axle beyond the wheelbase.
  EXPECT_THAT(
      message_of([] { static_cast<void>(parse_car({.wheelbase = "2", .front_axle = "3"})); }),
      HasSubstr("--front-axle"));
}

// odom init as a command: its file loads, and replays like the hand-written one.

class Init : public testing::Test {
 protected:
  static const Scratch& scratch() {
    static const SharedDrive made{"--seed 3", "lap"};
    return made.scratch;
  }
  [[nodiscard]] static Outcome init(const std::string& options) {
    return scratch().run("odom init " + options +
                         " --mass 2.985 --wheelbase 0.26 --front-axle 0.175");
  }
  [[nodiscard]] static json errors(const std::string& config) {
    return errors_of_replay(scratch(), "--can lap/drive.log --initial 0,0,0 --config lap/" + config,
                            "lap/truth.csv --align first");
  }
};

TEST_F(Init, WritesAConfigurationThatReplaysLikeTheHandWrittenOne) {
  const Outcome outcome =
      init("--dbc lap/car.dbc --can lap/drive.log --json --force --out lap/init.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json result = json::parse(outcome.out);
  ASSERT_EQ(result["roles"].size(), 8U);
  for (const json& role : result["roles"])
    EXPECT_THAT(role, Includes(R"({"sure": true, "scale": 1.0})"));
  EXPECT_NEAR(result["vehicle"]["track_width"]["value"].get<double>(), 0.16, 0.008);
  scratch().must_run("odomd --check --config lap/init.toml");
  const json by_hand = errors("car.toml"), proposed = errors("init.toml");
  for (const char* error : {"position", "heading"})
    EXPECT_LT(proposed[error]["rms"], 1.1 * by_hand[error]["rms"].get<double>()) << error;
}

TEST_F(Init, KnowsItsOwnBusWithoutADatabaseAndProtectsIt) {
  std::filesystem::create_directory(scratch().path("own"));
  const Outcome outcome = init("--can lap/drive.log --out own/car.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(scratch().path("own/odomd.dbc")));
  EXPECT_THAT(scratch().text("own/car.toml"),
              AllOf(HasSubstr("data_id = 0x1A2"), HasSubstr("# position = ["),
                    HasSubstr("# lever_arm = [")));
  scratch().must_run("odomd --check --config own/car.toml");
}

TEST_F(Init, IsUnsureOfEveryRoleWithoutALog) {
  const Outcome outcome = init("--json --track 0.16 --dbc lap/car.dbc --out lap/database.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json roles = json::parse(outcome.out).at("roles");
  ASSERT_FALSE(roles.empty());
  for (const json& role : roles) EXPECT_EQ(role["sure"], false) << role;
}

TEST_F(Init, RefusesAndWritesNothing) {
  scratch().write("bad.dbc", "VERSION \"\"\nBO_ x\n");
  scratch().write("other.log", "(1.000000) can0 111#00\n(1.100000) can0 111#00\n");
  scratch().write("lamps.dbc",
                  "VERSION \"\"\nBU_: A\nBO_ 273 LAMP: 1 A\n"
                  " SG_ On : 0|8@1+ (1,0) [0|1] \"\" A\n");
  const std::string before = scratch().text("lap/car.toml");
  // Wheels and gyro give the track.
  EXPECT_THAT(
      scratch().run("odom init --out refused.toml --can lap/drive.log"),
      Ends(2, AllOf(HasSubstr("--mass"), HasSubstr("--wheelbase"), Not(HasSubstr("--track")))));
  for (const auto& [options, says] : {std::pair{"refused.toml --dbc bad.dbc", "bad.dbc:2"},
                                      {"refused.toml --can other.log", "--dbc"},
                                      {"refused.toml --can other.log --dbc lamps.dbc", "lamps.dbc"},
                                      {"lap/car.toml --can lap/drive.log", "--force"}})
    EXPECT_THAT(init(std::string("--out ") + options), Ends(2, HasSubstr(says)));
  EXPECT_FALSE(std::filesystem::exists(scratch().path("refused.toml")));
  EXPECT_EQ(scratch().text("lap/car.toml"), before);
}

}  // namespace
}  // namespace odomd::tools::car_init_test
