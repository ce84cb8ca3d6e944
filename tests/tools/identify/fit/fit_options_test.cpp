// The command line of odom identify fit, before it starts odom-fit.
#include <CLI/CLI.hpp>

#include "tests/tools/scratch.hpp"
#include "tools/identify/fit/options.hpp"
#include "tools/identify/fit/parameters.hpp"

namespace odomd::tools::fit_options_test {
namespace {

using fitting::parse_prior;

std::string refusal(std::vector<std::string> arguments) {
  CLI::App app;
  FitOptions options;
  describe_fit(Command(app), options);
  std::ranges::reverse(arguments);  // the order that CLI11 expects
  app.parse(arguments);
  try {
    check(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

TEST(FitOptions, RefusesOptionsThatContradictEachOther) {
  const std::pair<std::vector<std::string>, std::string> cases[]{
      {{"--drive=lap"}, "taken"},
      {{"--drive=lap", "--from=-1"}, "--from"},
      {{"--drive=lap", "--from=5", "--to=6"}, "ten seconds"},
      {{"--drive=lap", "--fix=giro_bias"}, "gyro_bias"},
      {{"--drive=lap", "--fix=nosuch"}, "available: stiffness_front"}};
  for (const auto& [arguments, says] : cases) EXPECT_THAT(refusal(arguments), HasSubstr(says));
  EXPECT_THAT(refusal({"--drive=lap", "--fix=nosuch"}), testing::Not(HasSubstr("nearest")));
}

TEST(FitOptions, APriorIsANameAndASigma) {
  EXPECT_EQ(parse_prior("yaw_inertia=0.02").parameter, fitting::yaw_inertia);
  EXPECT_FALSE(parse_prior("mass=0.002").parameter.has_value());
  const std::pair<const char*, double> sigmas[]{
      {"yaw_inertia=0.02", 0.02},  {"mass=0.2%", 0.002}, {"camera_x=5mm", 0.005},
      {"gyro_latency=2ms", 0.002}, {"mass=1", 1.0},      {"accel_bias_x=2", 2.0}};
  for (const auto& [text, sigma] : sigmas) EXPECT_DOUBLE_EQ(parse_prior(text).sigma, sigma) << text;
  const std::pair<const char*, const char*> refusals[]{
      {"camera_x=2%", "the unit must be m, cm or mm"},
      {"yaw_inertia=200%", "200 %"},
      {"mass=2.9", "290 %"},
      {"mass=2.9", "as a share of it"},
      {"stiffness_front=20", "2000 %"},
      {"mas=0.1", "'mass'"},
      {"giro_bias=0.1", "'gyro_bias'"},
      {"mass", "NAME=SIGMA"},
      {"mass=", "NAME=SIGMA"},
      {"mass=0", "--prior mass"},
      {"mass=-1", "--prior mass"},
      {"mass=inf", "--prior mass"},
      {"mass=1x", "--prior mass"},
      {"", "NAME=SIGMA"},
      {"=1", "not a parameter"}};
  for (const auto& [text, says] : refusals)
    EXPECT_THAT(message_of([&] { (void)parse_prior(text); }), HasSubstr(says)) << text;
}

}  // namespace
}  // namespace odomd::tools::fit_options_test
