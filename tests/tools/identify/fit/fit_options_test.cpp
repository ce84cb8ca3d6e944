// What odom identify fit makes of its command line before it hands over to odom-fit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/scratch.hpp"
#include "tools/identify/fit/options.hpp"
#include "tools/identify/fit/parameters.hpp"

namespace odomd::tools::fit_options_test {
namespace {

using fitting::parse_prior;
using testing::HasSubstr;

std::string refusal(std::vector<std::string> arguments) {
  CLI::App app;
  FitOptions options;
  describe_fit(Command(app), options);
  std::ranges::reverse(arguments);  // as CLI11 takes them
  app.parse(arguments);
  try {
    check(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

TEST(FitOptions, WhatDoesNotHangTogetherIsRefused) {
  EXPECT_EQ(refusal({"--drive=lap"}), "taken");
  EXPECT_EQ(refusal({"--config=car.toml", "--can=a.log", "--camera=c.csv", "--from=5", "--to=15"}),
            "taken");
  EXPECT_THAT(refusal({"--can=a.log", "--camera=c.csv"}), HasSubstr("--config"));
  EXPECT_THAT(refusal({}), HasSubstr("--drive DIR"));
  EXPECT_THAT(refusal({"--can=a.log"}), HasSubstr("--camera or --reference"));
  EXPECT_THAT(refusal({"--can=a.log", "--camera=c.csv", "--reference=t.csv"}),
              HasSubstr("either --camera or --reference"));
  EXPECT_THAT(refusal({"--camera=c.csv"}), HasSubstr("--can"));
  EXPECT_THAT(refusal({"--drive=lap", "--from=-1"}), HasSubstr("--from"));
  EXPECT_THAT(refusal({"--drive=lap", "--from=5", "--to=6"}), HasSubstr("ten seconds"));
  EXPECT_THAT(refusal({"--drive=lap", "--reference-sigma", "0.01", "0"}),
              HasSubstr("--reference-sigma"));
  EXPECT_THAT(refusal({"--drive=lap", "--fix=giro_bias"}), HasSubstr("gyro_bias"));
  EXPECT_THAT(refusal({"--drive=lap", "--plot=rest.jpg"}), HasSubstr(".svg"));
}

TEST(FitOptions, AnUnknownNameListsAll) {
  EXPECT_THAT(
      refusal({"--drive=lap", "--fix=nosuch"}),
      testing::AllOf(HasSubstr("available: stiffness_front"), testing::Not(HasSubstr("nearest"))));
}

TEST(FitOptions, APriorIsANameAndASigma) {
  EXPECT_EQ(parse_prior("yaw_inertia=0.02").parameter, fitting::yaw_inertia);
  EXPECT_EQ(parse_prior("yaw_inertia=0.02").sigma, 0.02);
  EXPECT_FALSE(parse_prior("mass=0.002").parameter.has_value());
  EXPECT_DOUBLE_EQ(parse_prior("mass=0.2%").sigma, 0.002);
  EXPECT_DOUBLE_EQ(parse_prior("camera_x=5mm").sigma, 0.005);
  EXPECT_DOUBLE_EQ(parse_prior("gyro_latency=2ms").sigma, 0.002);
  EXPECT_THAT(message_of([] { (void)parse_prior("camera_x=2%"); }),
              HasSubstr("the unit must be m, cm or mm"));
  EXPECT_THAT(message_of([] { (void)parse_prior("yaw_inertia=200%"); }), HasSubstr("200 %"));
  for (const std::string wrong :
       {"mass", "mass=", "mass=0", "mass=-1", "mass=inf", "mass=1x", "", "=1", "mas=1"}) {
    EXPECT_THROW(static_cast<void>(parse_prior(wrong)), std::invalid_argument) << wrong;
  }
}

TEST(FitOptions, WithoutTheProgramItIsSaidHowToHaveIt) {
  const Scratch scratch;
  const std::string alone = scratch.path("odom").string();
  EXPECT_THAT(run_shell("cp \"$(command -v odom)\" " + alone + " && exec " + alone +
                        " identify fit --drive somewhere"),
              Ends(1,
                   "odom identify fit: fitting needs odom-fit: install the package odom-fit; or "
                   "install libceres-dev, and configure and build all: cmake --preset release && "
                   "cmake --build --preset release\n"));
}

std::string refusal_of_prior(const std::string& text) {
  try {
    static_cast<void>(parse_prior(text));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

TEST(FitOptions, APriorThatIsAShareIsNoValue) {
  EXPECT_THAT(refusal_of_prior("mass=2.9"), HasSubstr("290 %"));
  EXPECT_THAT(refusal_of_prior("mass=2.9"), HasSubstr("as a share of it"));
  EXPECT_THAT(refusal_of_prior("stiffness_front=20"), HasSubstr("2000 %"));
  EXPECT_EQ(refusal_of_prior("mass=1"), "taken");
  EXPECT_EQ(refusal_of_prior("accel_bias_x=2"), "taken");  // m/s2
}

TEST(FitOptions, AMisspeltPriorMayBeTheMass) {
  EXPECT_THAT(refusal_of_prior("mas=0.1"), HasSubstr("'mass'"));
  EXPECT_THAT(refusal_of_prior("giro_bias=0.1"), HasSubstr("'gyro_bias'"));
}

TEST(FitOptions, WithoutItsProgramTheCommandSaysWhatToInstall) {
  const Scratch scratch;
  std::filesystem::copy_file(ODOMD_BIN_DIR "/odom", scratch.path("odom"));
  const Outcome outcome =
      run_shell(scratch.path("odom").string() + " identify fit --config car.toml --drive lap");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("libceres-dev"));
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1);
}

}  // namespace
}  // namespace odomd::tools::fit_options_test
