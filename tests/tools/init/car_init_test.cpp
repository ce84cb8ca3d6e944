// odom init as a command, and the numbers of the car that it needs.
#include <nlohmann/json.hpp>

#include <filesystem>

#include "tests/gtest.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools::car_init_test {
namespace {

using estimator::Source;
using nlohmann::json;

TEST(Car, RefusesAnAxleBeyondTheWheelbase) {
  EXPECT_THAT(
      message_of([] { static_cast<void>(parse_car({.wheelbase = "2", .front_axle = "3"})); }),
      HasSubstr("--front-axle"));
}

TEST(Car, OnlyWhatARoleNeedsIsMissing) {
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
}

// odom init as a command: its file loads, and replays like the hand-written one.

class Init : public testing::Test {
 protected:
  static const SharedDrive& shared() {
    static const SharedDrive made{"--seed 3", "lap"};
    return made;
  }
  [[nodiscard]] Outcome init(const std::string& options,
                             const std::string& out = "init.toml") const {
    return run_shell("odom init --out " + lap_ + "/" + out + " " + options);
  }
  [[nodiscard]] json errors(const std::string& config) const {
    const std::string pose = lap_ + "/" + config + ".csv";
    must_run("odom replay --config " + lap_ + "/" + config + " --can " + lap_ +
             "/drive.log --initial 0,0,0 --out " + pose);
    const Outcome outcome = run_shell("odom evaluate --align first --json --reference " + lap_ +
                                      "/truth.csv --pose " + pose);
    return json::parse(outcome.out)["estimates"][0];
  }

  const Scratch& scratch_ = shared().scratch;
  const std::string lap_ = shared().folder.string();
  static constexpr const char* car = " --mass 2.985 --wheelbase 0.26 --front-axle 0.175";
};

TEST_F(Init, WritesWhatReplaysAsTheConfigurationByHand) {
  const Outcome outcome =
      init("--dbc " + lap_ + "/car.dbc --can " + lap_ + "/drive.log --json --force" + car);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json result = json::parse(outcome.out);
  ASSERT_EQ(result["roles"].size(), 8U);
  for (const json& role : result["roles"]) {
    EXPECT_TRUE(role["sure"].get<bool>()) << role;
    EXPECT_EQ(role["scale"], 1.0) << role;
  }
  EXPECT_NEAR(result["vehicle"]["track_width"]["value"].get<double>(), 0.16, 0.008);
  must_run("odomd --check --config " + lap_ + "/init.toml");
  const json by_hand = errors("car.toml"), proposed = errors("init.toml");
  EXPECT_LT(proposed["position"]["rms"], 1.1 * by_hand["position"]["rms"].get<double>());
  EXPECT_LT(proposed["heading"]["rms"], 1.1 * by_hand["heading"]["rms"].get<double>());
}

TEST_F(Init, KnowsItsOwnBusWithoutADatabaseAndProtectsIt) {
  const std::string folder = lap_ + "/own";
  std::filesystem::create_directory(folder);
  const Outcome outcome = init("--can " + lap_ + "/drive.log" + car, "own/car.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder + "/odomd.dbc"));
  EXPECT_THAT(contents(folder + "/car.toml"),
              AllOf(HasSubstr("data_id = 0x1A2"), HasSubstr("# position = ["),
                    HasSubstr("# lever_arm = [")));
  must_run("odomd --check --config " + folder + "/car.toml");
}

TEST_F(Init, WithoutALogSaysThatNothingWasCompared) {
  const Outcome outcome =
      init("--json --track 0.16 --dbc " + lap_ + "/car.dbc" + car, "database.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json roles = json::parse(outcome.out).at("roles");
  ASSERT_FALSE(roles.empty());
  for (const json& role : roles) EXPECT_FALSE(role["sure"].get<bool>()) << role;
}

TEST_F(Init, RefusesAndWritesNothing) {
  const std::string log = "--can " + lap_ + "/drive.log";
  const std::string bad = scratch_.write("bad.dbc", "VERSION \"\"\nBO_ x\n").string();
  const std::string other =
      scratch_.write("other.log", "(1.000000) can0 111#00\n(1.100000) can0 111#00\n").string();
  const std::string lamps =
      scratch_
          .write("lamps.dbc",
                 "VERSION \"\"\nBU_: A\nBO_ 273 LAMP: 1 A\n SG_ On : 0|8@1+ (1,0) [0|1] \"\" A\n")
          .string();
  const std::pair<std::string, ::testing::Matcher<std::string>> cases[]{
      // Wheels and gyro give the track.
      {log, AllOf(HasSubstr("--mass"), HasSubstr("--wheelbase"), Not(HasSubstr("--track")))},
      {"--dbc " + bad + car, HasSubstr("bad.dbc:2")},
      {"--can " + other + car, HasSubstr("--dbc")},
      {"--can " + other + " --dbc " + lamps + car, HasSubstr("lamps.dbc")}};
  for (const auto& [options, message] : cases) {
    EXPECT_THAT(init(options, "refused.toml"), Ends(2, message));
    EXPECT_FALSE(std::filesystem::exists(lap_ + "/refused.toml"));
  }
  const std::string before = contents(lap_ + "/car.toml");
  EXPECT_THAT(init(log + car, "car.toml"), Ends(2, HasSubstr("--force")));
  EXPECT_EQ(contents(lap_ + "/car.toml"), before);
}

}  // namespace
}  // namespace odomd::tools::car_init_test
