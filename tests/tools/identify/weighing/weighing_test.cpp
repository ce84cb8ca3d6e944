#include "tools/identify/weighing/weighing.hpp"

#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/inputs.hpp"

namespace odomd::tools::weighing_test {
namespace {

TEST(Quantity, IsConvertedFromItsUnit) {
  EXPECT_DOUBLE_EQ(parse_quantity("2.985", Dimension::mass, "--x"), 2.985);
  EXPECT_DOUBLE_EQ(parse_quantity(" 2985 g ", Dimension::mass, "--x"), 2.985);
  EXPECT_EQ(parse_quantity("175mm", Dimension::length, "--x"), 0.175);  // exact
  EXPECT_DOUBLE_EQ(parse_positive("26cm", Dimension::length, "--x"), 0.26);
  EXPECT_DOUBLE_EQ(parse_positive("180deg", Dimension::angle, "--x"), 3.14159265358979323846);
  EXPECT_DOUBLE_EQ(parse_not_negative("0.1%", Dimension::pure, "--x"), 0.001);
}

TEST(Quantity, IsRefusedWithAnotherUnitOrIfImpossible) {
  const std::pair<const char*, const char*> cases[]{
      {"3mm", "--front: \"3mm\": the unit must be kg or g"},
      {"3N", "--front: \"3N\": the unit must be kg or g"},
      {"3,015", "--front: \"3,015\": write a decimal point, not a comma"},
      {"", "--front: "},
      {"kg", "--front: "},
      {"nan", "--front: "},
      {"inf", "--front: "},
      {"1e999", "--front: "},
      {"0", "must be greater than 0"},
      {"-1", "must be greater than 0"}};
  for (const auto& [text, says] : cases)
    EXPECT_THAT(message_of([&] { (void)parse_positive(text, Dimension::mass, "--front"); }),
                HasSubstr(says))
        << text;
  EXPECT_DOUBLE_EQ(parse_plausible("200mm", Dimension::length, "--spacing", {0.01, 10.0}), 0.2);
  EXPECT_EQ(message_of([] {
              (void)parse_plausible("239.5", Dimension::length, "--spacing", {0.01, 10.0});
            }),
            "--spacing: \"239.5\" is 239.5 m, but 0.01 to 10 m is plausible; a number without a "
            "unit is in m; units are m, cm or mm");
}

constexpr Scale scale{.resolution = 0.0, .sigma = 0.002, .accuracy = 0.001};

std::optional<Measured> mass(const std::vector<Weighing>& weighings, const Scale& by = scale) {
  return mass_of(wheel_loads(weighings, by), by);
}

TEST(Weighing, ReducesScatterByRepetitionButNotGainOrRounding) {
  const std::vector<Weighing> four(4, {Load::total, 2.0});
  ASSERT_TRUE(mass(four));
  EXPECT_DOUBLE_EQ(mass(four)->value, 2.0);
  EXPECT_NEAR(mass(four)->sigma, std::hypot(0.001, 0.002), 1e-12);
  EXPECT_NEAR(mass(four, {.resolution = 0.012, .sigma = 1e-9})->sigma, 0.012 / std::sqrt(12.0),
              1e-6);
}

TEST(Weighing, AddsPartsThatDetermineTheWhole) {
  const auto axles = mass({{Load::front, 1.0}, {Load::rear, 2.0}});
  EXPECT_NEAR(axles->value, 3.0, 1e-12);
  EXPECT_NEAR(axles->sigma, std::hypot(0.002 * std::sqrt(2.0), 0.003), 1e-12);
  const auto wheels = mass({{Load::front_left, 0.5},
                            {Load::front_right, 0.6},
                            {Load::rear_left, 0.7},
                            {Load::rear_right, 0.8}});
  EXPECT_NEAR(wheels->value, 2.6, 1e-12);
  EXPECT_FALSE(mass({{Load::front, 1.0}, {Load::left, 2.0}}));
}

TEST(Weighing, WidensTheUncertaintyForContradictionsAndReportsThem) {
  const auto contradiction_in = [](const std::vector<Weighing>& weighings, const Scale& by) {
    return contradiction(wheel_loads(weighings, by));
  };
  const auto axles_and = [](double total) {
    return std::vector<Weighing>{{Load::front, 1.0}, {Load::rear, 2.0}, {Load::total, total}};
  };
  EXPECT_THAT(contradiction_in(axles_and(3.1), scale),
              testing::Optional(diagnostics::Named("weighings_contradict", "28.9 times")));
  EXPECT_GT(mass(axles_and(3.1))->sigma, 0.04);
  EXPECT_FALSE(contradiction_in(axles_and(3.003), scale));
  // These weighings differ by a digit of the scale.
  const std::vector<Weighing> close{
      {Load::total, 2.985}, {Load::total, 2.986}, {Load::total, 2.985}};
  EXPECT_FALSE(contradiction_in(close, {.resolution = 0.001}));
  EXPECT_NEAR(mass(close, {.resolution = 0.001})->value, 2.9853, 1e-3);
  EXPECT_LT(mass(close, {.resolution = 0.001})->sigma, 0.001);
  // They scatter.
  const auto both = mass({{Load::total, 2.98}, {Load::total, 3.02}});
  EXPECT_NEAR(both->value, 3.0, 1e-9);
  EXPECT_NEAR(both->sigma, 0.02, 0.003);
}

TEST(Weighing, RefusesImpossibleLoads) {
  const Scale grams{.resolution = 0.001};
  const struct {
    std::vector<Weighing> weighings;
    Scale scale;
    ::testing::Matcher<std::string> says;
  } cases[]{{{{Load::total, 2985.0}},
             grams,
             "--total: no scale shows 2985 kg with steps of 0.001 kg; write grams as 2985g"},
            {{{Load::front, 978.0}, {Load::rear, 2.006}},
             grams,
             HasSubstr("--front: no scale shows 978 kg with steps of 0.001 kg")},
            {{{Load::front, 3.2}, {Load::total, 3.0}},
             scale,
             HasSubstr("--front: 3.2 kg is more than the whole car, 3 kg")},
            {{{Load::right, 3.2}, {Load::total, 3.0}}, scale, HasSubstr("--right: ")},
            {{{Load::total, 1.0}}, {}, HasSubstr("--scale-resolution")},
            {{}, scale, HasSubstr("no load is given")},
            {{{Load::rear_left, 0.0}},
             scale,
             "--rear-left: 0 kg is not possible; it must be greater than 0"}};
  const auto refusal = [](const std::vector<Weighing>& weighings, const Scale& by) {
    return message_of([&] { check_shares(wheel_loads(weighings, by)); });
  };
  for (const auto& [weighings, by, says] : cases) EXPECT_THAT(refusal(weighings, by), says);
  EXPECT_EQ(refusal({{Load::front, 1.2}, {Load::total, 3.0}}, scale), "");
}

TEST(Weighing, ComputesTheCentreOfGravity) {
  const std::vector<Weighing> weighings{
      {Load::front, 1.0}, {Load::rear, 2.0}, {Load::left, 1.6}, {Load::right, 1.4}};
  const Dimensions tape{.wheelbase = {0.3, 0.0}, .track_width = Measured{0.15, 0.0}};
  const CentreOfGravity centre = centre_of_gravity(wheel_loads(weighings, scale), tape);
  EXPECT_NEAR(centre.front_axle->value, 0.2, 1e-12);
  EXPECT_NEAR(centre.rear_axle->value, 0.1, 1e-12);
  EXPECT_NEAR(centre.lateral->value, 0.15 * (1.6 / 3.0 - 0.5), 1e-12);
  EXPECT_NEAR(centre.correlation, -1.0, 1e-12);
  // sigma of l F_r / (F_f + F_r) from axles alone: l sigma sqrt(F_f² + F_r²) / m².
  const std::vector<Weighing> axles{{Load::front, 1.0}, {Load::rear, 2.0}};
  EXPECT_NEAR(centre_of_gravity(wheel_loads(axles, scale), tape).front_axle->sigma,
              0.3 * 0.002 * std::sqrt(5.0) / 9.0, 1e-12);
}

TEST(Weighing, AllowsForTapeAndSlope) {
  const Scale exact{.sigma = 1e-9};
  const std::vector<Weighing> axles{{Load::front, 1.0}, {Load::rear, 2.0}};
  const CentreOfGravity tape =
      centre_of_gravity(wheel_loads(axles, exact), {.wheelbase = {0.3, 0.003}});
  EXPECT_NEAR(tape.front_axle->sigma, 0.002, 1e-9);
  EXPECT_NEAR(tape.rear_axle->sigma, 0.001, 1e-9);
  EXPECT_NEAR(tape.correlation, 1.0, 1e-6);
  // Each axle stands on a different slope: l_h = l F_v / (F_v + F_h).
  const Dimensions level{.wheelbase = {0.3, 0.0}, .level = 0.01};
  const Scale sloping = with_slopes(exact, 3.0, level);
  EXPECT_NEAR(sloping.axle_shift, 0.0075, 1e-6);
  EXPECT_NEAR(centre_of_gravity(wheel_loads(axles, sloping), level).rear_axle->sigma,
              0.3 * 0.0075 * std::sqrt(5.0) / 9.0, 1e-6);
}

TEST(Findings, HaveAPercentageUnlessZeroIsANormalValue) {
  const auto text = [](Finding finding) { return as_text({.method = "cog", .values = {finding}}); };
  const auto finding = [](const char* key, double value, double sigma) {
    return Finding{.name = "x", .key = key, .value = value, .sigma = sigma, .unit = "m"};
  };
  EXPECT_THAT(text(finding("", 1e-5, 1e-3)), Not(HasSubstr("%")));
  EXPECT_THAT(text(finding("", 0.01, 1e-3)), HasSubstr(" 20 %"));
  EXPECT_THAT(text(finding("", 1.0, 1e-3)), HasSubstr(" 0.20 %"));
  EXPECT_THAT(text({.name = "bias", .value = 1.0, .sigma = 0.1, .share = Share::meaningless}),
              Not(HasSubstr("%")));
  for (const char* key : {"can.signals.yaw_rate.latency", "can.signals.accel_x.offset",
                          "imu.position[0]", "camera.lever_arm[2]"})
    EXPECT_THAT(text(finding(key, 1.0, 0.1)), Not(HasSubstr("%"))) << key;
}

constexpr const char* car_toml =
    "[vehicle] # mine\nmass = 2.985  # kg\nfront_axle = 0.175\nrear_axle = 0.085\n"
    "yaw_inertia = 0.028\ncornering_stiffness_front = 20\n"
    "cornering_stiffness_rear = 60\ntrack_width = 0.16\n[can]\nsource = \"can0\"\n"
    "dbc = \"a.dbc\"\n[can.signals]\nwheel_rear = { message = \"W\", signal = \"S\", "
    "unit = \"m/s\" }\n";

TEST(IdentifyMass, ReportsAndWrites) {
  const Scratch scratch;
  scratch.write("car.toml", car_toml);
  EXPECT_THAT(
      scratch.must_run("odom identify mass --total 3021g --total 3.02 --scale-resolution 1g "
                       "--scale-sigma 1g --write car.toml"),
      HasSubstr("3.0205"));
  EXPECT_THAT(scratch.text("car.toml"),
              HasSubstr("mass = 3.0205  # kg (odom identify mass: +- 0.0062 kg, scale, 2 "
                        "weighings)\n"));
  const Outcome cog = scratch.run(
      "odom identify cog --front 1 --rear 2 --scale-resolution 1g --wheelbase 270mm --json "
      "--write car.toml");
  EXPECT_THAT(cog, Ends(0, HasSubstr("make a wheelbase of 0.2600 m, measured are 0.2700 m")));
  EXPECT_THAT(cog.out, HasSubstr("\"vehicle.rear_axle\""));
  EXPECT_THAT(scratch.text("car.toml"), HasSubstr("\nfront_axle = 0.18"));
}

TEST(IdentifyMass, ReportsAnUnwritableTargetBeforeTheWorkOrPrintsItsNumbers) {
  const Scratch scratch;
  const std::string heavy = "[vehicle]\nmass = \"heavy\"\n";
  scratch.write("broken.toml", "[vehicle\n");
  scratch.write("car.toml", car_toml);
  scratch.write("heavy.toml", heavy);
  scratch.write("m.json", R"({"total": 2,985, "front": 1.0})");
  expect_answers(scratch, 2, "odom identify mass", R"(
--total 3apples --write nope.toml -> nope.toml: there is no such file
--total 3apples --write . -> is a directory
--total 3apples --write broken.toml -> broken.toml:
--total 3apples --write car.toml -> 3apples
--scale-resolution 1g --measured m.json -> m.json: total: write a number with a decimal point:
  2.5, not 2,5
)");
  EXPECT_EQ(scratch.text("car.toml"), car_toml);
  const Outcome outcome =
      scratch.run("odom identify mass --total 3 --scale-resolution 1g --write heavy.toml");
  EXPECT_THAT(outcome, Ends(2, HasSubstr("heavy.toml:2")));
  EXPECT_THAT(outcome.out, HasSubstr("vehicle.mass"));
  EXPECT_EQ(scratch.text("heavy.toml"), heavy);
}

TEST(IdentifyMass, HasTheSameUncertaintyAsCogIfAxlesAreWeighed) {
  const std::string loads = " --front 1 --rear 2 --scale-resolution 1g --json";
  const auto sigma = [&](const std::string& method) {
    const auto json = nlohmann::json::parse(must_run("odom identify " + method + loads));
    return json["values"].back()["sigma"].get<double>();
  };
  // Weighed axle by axle, 0.25° of slope shifts the load by m h/l tan θ; h/l = 1/4.
  const double shift = 3.0 * 0.25 * std::tan(0.25 / 57.29577951308232);
  EXPECT_NEAR(sigma("mass"), std::hypot(std::sqrt(2.0) * shift, 0.003), 1e-4);
  EXPECT_NEAR(sigma("mass"), sigma("cog --wheelbase 0.26"), 1e-12);
  EXPECT_LT(sigma("mass --level 0"), 0.0032);
}

TEST(IdentifyMass, ReportsMissingLoadsAndWrongUnits) {
  const Scratch scratch;
  expect_answers(scratch, 0, "odom identify", R"(
mass --total 2.985 --scale-resolution 1 -> warning: 2 sigma of the mass is 38.7 %
)");
  expect_answers(scratch, 2, "odom identify", R"(
mass --total 2.985 --scale-resolution 1g --scale-accuracy 5 -> mass: --scale-accuracy: 5 is more
  than 10 %; a number without % is a fraction
cog --front 1 --rear 2 --scale-resolution 1g --wheelbase 0.26 --wheelbase-sigma 1 -> cog:
  --wheelbase-sigma: 1 is more than a tenth of 0.26 m
mass --front 1 --scale-resolution 1g -> do not add up to the whole car
cog --total 3 --scale-sigma 1g --wheelbase 1 -> do not determine the weight distribution
)");
}

}  // namespace
}  // namespace odomd::tools::weighing_test
