// Cornering stiffnesses from circles.
#include "tests/tools/scratch.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"

namespace odomd::tools::stiffness_test {
namespace {

// The reference car, and values missing in its configuration.
struct Truth {
  double front = 20.0, rear = 60.0;
  double steering_offset = 0.006, steering_scale = 1.015, marker_angle = 0.002;
};

CircleCar car() {
  return {.mass = {2.985, 0.005},
          .front_axle = {0.175, 0.0005},
          .rear_axle = {0.085, 0.0005},
          .rolling_resistance = {0.0, 0.001},
          .sigma_scale = 0.003,
          .sigma_marker = 0.001,
          .marker_distance = 0.3};
}

// A steady circle of a car with linear tyres: speed and radius (left positive) determine ψ̇,
// forces, slip angles, drift and steering.
CircleRun circle(const Truth& truth, double speed, double radius) {
  const double yaw_rate = speed / radius, l_v = 0.175, l_h = 0.085, m = 2.985;
  double drift = 0.0, accel = 0.0, steering = 0.0;
  for (int k = 0; k < 50; ++k) {
    accel = speed * std::cos(drift) * yaw_rate;
    const double slip_rear = l_v * m * accel / (0.26 * truth.rear);
    const double v_x = speed * std::cos(drift);
    drift = std::atan2(l_h * yaw_rate - v_x * std::tan(slip_rear), v_x);
    const double slip_front = l_h * m * accel / (0.26 * std::cos(steering) * truth.front);
    steering = slip_front + std::atan2(speed * std::sin(drift) + l_v * yaw_rate, v_x);
  }
  CircleRun run{.film = "film.csv", .speed = speed, .yaw_rate = yaw_rate, .lateral_accel = accel};
  run.drift = {drift + truth.marker_angle, 2e-4};
  run.steering = {truth.steering_scale * steering + truth.steering_offset, 2e-4};
  return run;
}

std::vector<CircleRun> circles(const Truth& truth) {
  std::vector<CircleRun> runs;
  for (const double speed : {0.4, 0.7, 1.0, 1.2})
    for (const double radius : {1.2, -1.2}) runs.push_back(circle(truth, speed, radius));
  return runs;
}

TEST(CorneringStiffness, FindsTheSlopesTogetherWithOffsetsAndScales) {
  const Truth truth;
  const CorneringStiffness found = fit_stiffness(circles(truth), car());
  EXPECT_NEAR(found.front.stiffness.value, truth.front, 0.3);
  EXPECT_NEAR(found.rear.stiffness.value, truth.rear, 0.9);
  EXPECT_LT(2.0 * found.front.stiffness.sigma / truth.front, 0.06);
  EXPECT_LT(2.0 * found.rear.stiffness.sigma / truth.rear, 0.06);
  EXPECT_NEAR(found.steering_offset.value, truth.steering_offset, 1e-3);
  EXPECT_NEAR(found.steering_scale.value, truth.steering_scale, 0.01);
  EXPECT_NEAR(found.marker_angle.value, truth.marker_angle, 5e-4);
  // The picture shows both axles.
  const auto drawings = draw_stiffness(fit_stiffness(circles({}), car()));
  ASSERT_EQ(drawings.size(), 2U);
  EXPECT_THAT(drawings[0].svg, HasSubstr("slope at zero slip"));
  EXPECT_THAT(drawings[1].svg, HasSubstr("Rear axle"));
}

// The printed small-angle formulas over-read C_v by 4 % at δ = 0.3 (errata 8).
TEST(CorneringStiffness, LargeSteeringAnglesDoNotBiasIt) {
  Truth truth;
  truth.steering_offset = truth.marker_angle = 0.0;
  truth.steering_scale = 1.0;
  std::vector<CircleRun> runs;
  for (const double speed : {0.2, 0.4, 0.6, 0.8})
    for (const double radius : {0.7, -0.7}) runs.push_back(circle(truth, speed, radius));
  EXPECT_GT(runs.back().steering.value, -0.5);
  EXPECT_LT(runs.back().steering.value, -0.35);
  EXPECT_NEAR(fit_stiffness(runs, car()).front.stiffness.value, truth.front, 0.15);
}

TEST(CorneringStiffness, IgnoresOneCircleThatIsOff) {
  const Truth truth;
  std::vector<CircleRun> runs = circles(truth);
  runs[4].drift.value += 0.02;
  const CorneringStiffness found = fit_stiffness(runs, car());
  EXPECT_NEAR(found.rear.stiffness.value, truth.rear, 2.0 * found.rear.stiffness.sigma);
  EXPECT_LT(found.rear.points[4].weight, 0.5);
}

TEST(CorneringStiffness, IsLessPreciseWithOneDirectionOnly) {
  const Truth truth;
  std::vector<CircleRun> left;
  for (const CircleRun& run : circles(truth))
    if (run.yaw_rate > 0.0) left.push_back(run);
  const CorneringStiffness one = fit_stiffness(left, car());
  const CorneringStiffness both = fit_stiffness(circles(truth), car());
  EXPECT_GT(one.steering_offset.sigma, 3.0 * both.steering_offset.sigma);
  EXPECT_NEAR(one.front.stiffness.value, truth.front, 2.0 * one.front.stiffness.sigma);
}

TEST(CorneringStiffness, LessPreciseInputsGiveLargerUncertainties) {
  const std::vector<CircleRun> runs = circles({});
  CircleCar rough = car();
  rough.mass.sigma = 0.15;
  const double sigma = fit_stiffness(runs, rough).rear.stiffness.sigma;
  EXPECT_GT(sigma / 60.0, 0.05);
  EXPECT_GT(sigma, 2.0 * fit_stiffness(runs, car()).rear.stiffness.sigma);
}

TEST(CorneringStiffness, DeterminesNothingAtWalkingPace) {
  std::vector<CircleRun> runs;
  for (const double radius : {1.2, -1.2}) runs.push_back(circle({}, 0.1, radius));
  const CorneringStiffness found = fit_stiffness(runs, car());
  EXPECT_GT(4.0 * found.rear.stiffness.sigma, found.rear.stiffness.value);
  EXPECT_THROW((void)fit_stiffness({}, car()), std::invalid_argument);
}

// odom identify stiffness on simulated circles, and its errors if something went wrong.

// One simulated drive for all tests.
const SharedDrive& afternoon() {
  static const SharedDrive made{"--scenario circles --markers --seed 3 --fix mass_error=0"};
  return made;
}

Outcome identify(const std::string& options) {
  return afternoon().run("odom identify stiffness " + options);
}

const std::string places = "--front 18cm,0 --rear -120mm,0 ";
const std::string film = "--y-down --run markers.csv,drive.log ";
const std::string as_it_is = "--config car.toml " + places + film;

std::string contents(const std::string& file) {
  return tools::contents(afternoon().folder / file);
}

void write(const std::string& file, const std::string& text) {
  std::ofstream(afternoon().folder / file) << text;
}

TEST(StiffnessCommand, WritesTheTruthWithinTwoSigma) {
  write("mine.toml", contents("car.toml"));
  const Outcome outcome = identify(as_it_is + "--json --plot tyres.svg --write mine.toml");
  ASSERT_THAT(outcome,
              Ends(0,
                   "odom identify stiffness: 2 keys written to mine.toml: "
                   "vehicle.cornering_stiffness_front, vehicle.cornering_stiffness_rear\n"));
  const auto json = nlohmann::json::parse(outcome.out);
  const auto truth = nlohmann::json::parse(contents("plant.json"))["truth"];
  for (const auto& [axle, stiffness] : {std::pair{"front", 20.0}, {"rear", 60.0}}) {
    const double expected =
        stiffness * (1.0 + truth[std::string("stiffness_error_") + axle].get<double>());
    const auto& found = json["values"][axle == std::string("front") ? 0 : 1];
    EXPECT_NEAR(found["value"], expected, 2.0 * found["sigma"].get<double>()) << axle;
    EXPECT_LT(found["sigma"].get<double>(), 0.025 * expected) << axle;
  }
  EXPECT_EQ(json["details"]["circles"].size(), 12U);
  EXPECT_THAT(contents("mine.toml"), HasSubstr("odom identify stiffness"));
  EXPECT_THAT(contents("tyres.svg"), HasSubstr("</svg>"));
}

/// Uses a configuration in which `signal` has this scale.
Outcome identify_scaled(const std::string& signal, const std::string& scale) {
  std::string text = contents("car.toml");
  const std::string entry = "signal = " + signal;
  text.insert(text.find(entry) + entry.size(), ", scale = " + scale);
  write("scaled.toml", text);
  return identify("--config scaled.toml " + places + film);
}

TEST(StiffnessCommand, WarnsOfAContradictedScaleAndOfAnUncertainMass) {
  EXPECT_THAT(identify_scaled("\"AccY\", unit = \"m/s2\"", "1.05"),
              Ends(0, HasSubstr("% of the film's lateral acceleration")));
  std::string text = contents("car.toml");
  text.insert(text.find('\n', text.find("\nmass = ") + 1), "  # (odom identify mass: +- 0.3 kg)");
  write("vague.toml", text);
  EXPECT_THAT(identify("--config vague.toml " + places + film),
              Ends(0, HasSubstr("and 5 % is possible; drive faster circles")));
}

TEST(StiffnessCommand, DoesNotWriteWhatTheCirclesContradict) {
  const auto expect = [](const std::string& options, const std::string& reason) {
    const std::string car = contents("car.toml");
    write("kept.toml", car);
    const Outcome outcome =
        identify(options + "--config car.toml --json --write kept.toml " + film);
    EXPECT_EQ(outcome.status, 0) << options << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(reason)) << options;
    const auto json = nlohmann::json::parse(outcome.out);
    for (std::size_t axle = 0; axle < 2; ++axle)
      EXPECT_EQ(json["values"][axle]["determined"], false) << options;
    EXPECT_EQ(contents("kept.toml"), car) << options;
    EXPECT_THAT(outcome.err, HasSubstr("nothing written to kept.toml")) << options;
  };
  // Positions measured from the rear marker, from the front marker, and from mid-wheelbase.
  expect("--front 0.30,0 --rear 0,0 ",
         "centre of gravity lies 0.120 m ahead of the place in --front and");
  expect("--front 0,0 --rear -0.30,0 ", "centre of gravity lies 0.180 m behind the place");
  expect("--front 0.225,0 --rear -0.075,0 ", "centre of gravity lies 0.045 m ahead of");
  // The rear position lacks its minus sign.
  expect("--front 0.18,0 --rear 0.12,0 ", "of the film's lateral acceleration, and one of the two");
  expect("--front 0.18,0 --rear 0.12,0 ", "no marker lies behind the centre of gravity");
  expect("--front 0.36,0 --rear -0.24,0 ", "accelerometer reads 50 %");
}

TEST(StiffnessCommand, RefusesOrContradictsAWrongSteeringScale) {
  const auto with_scale = [](const std::string& scale) {
    return identify_scaled("\"SteeringAngle\", unit = \"rad\"", scale);
  };
  for (const char* scale : {"17", "0.0588"}) {
    EXPECT_THAT(with_scale(scale),
                Ends(2, HasSubstr("correct scale and unit of [can.signals] steering")));
  }
  const Outcome contradicted = with_scale("1.5");
  EXPECT_THAT(contradicted, Ends(0, HasSubstr("is 1.47 times the angle of the wheels")));
  EXPECT_THAT(contradicted.out, HasSubstr("not determined"));
}

TEST(StiffnessCommand, ReportsEachMistakeInOneLine) {
  std::string text = contents("car.toml");
  text.erase(text.find("[vehicle]"), text.find("[can]") - text.find("[vehicle]"));
  write("no_car.toml", text);
  // Only the slowest circles, with markers whose positions were not measured.
  std::string slow;
  std::istringstream lines(contents("markers.csv"));
  for (std::string line; std::getline(lines, line) && line.rfind("55.", 0) != 0;)
    slow += line + '\n';
  write("slow.csv", slow);
  const std::pair<std::string, std::string> cases[]{
      {places + "--run markers.csv,drive.log", "--y-down"},
      {"--front -0.12,0 --rear 0.18,0 " + film, "markers are swapped"},
      {"--front 0,0.18 --rear 0,-0.12 " + film, "the car moves sideways"},
      {"--front 0.18 --rear -0.12,0 " + film, "--front"},
      {"--front 18apples,0 --rear -0.12,0 " + film, "--front"},
      {places + film + "--sigma-marker 15g", "--sigma-marker"},
      {places + film + "--sigma-scale 30%", "30% is more than 10 %"},
      {places + film + "--sigma-scale 0.3", "a number without % is a fraction"},
      {places + "--y-down --run markers.csv", "is not MARKERS,LOG"},
      {places + "--y-down --run nothing.csv,drive.log", "no such file"},
      {places + film + "--metres-per-pixel 0.005", "correct the scale"},
      {places + film + "--plot tyres.jpg", ".svg"},
      {places + "--y-down --sigma-marker 2cm --run slow.csv,drive.log", "too slow"},
      {places + film + "--config no_car.toml", "[vehicle] mass is missing"}};
  for (const auto& [options, reason] : cases) {
    const bool named = options.find("--config") != std::string::npos;
    const Outcome outcome = identify(options + (named ? "" : " --config car.toml"));
    EXPECT_THAT(outcome,
                Ends(2, AllOf(StartsWith("odom identify stiffness: "), HasSubstr(reason))));
    EXPECT_EQ(outcome.out, "") << options;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace odomd::tools::stiffness_test
