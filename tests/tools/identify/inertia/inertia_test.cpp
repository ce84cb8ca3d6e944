// The pendulum's formulas compared with a rigid body on two elastic cords, and results from
// records.
#include <numbers>

#include "tests/tools/scratch.hpp"
#include "tools/identify/inertia/bifilar.hpp"
#include "tools/math/random.hpp"
#include "tools/sim/car/swing.hpp"

namespace odomd::tools::inertia_test {
namespace {

using std::numbers::pi;

constexpr Bifilar reference{.spacing_above = 0.2, .spacing_below = 0.2, .cord = 1.0};
constexpr double mass = 2.985, inertia = 0.0283384, gravity = 9.81;

// T = 2 π sqrt(J h / (m g p)) of the reference, for small swings.
double small_period(double g = gravity) {
  return 2.0 * pi * std::sqrt(inertia / (mass * g * 0.1 * 0.1));
}
double period_at(const Bifilar& pendulum, double amplitude) {
  const double small =
      std::sqrt(inertia / mass / inertia_per_mass(pendulum, 1.0, gravity));  // J/m ~ T²
  return small * lengthening(pendulum, inertia / mass, amplitude);
}

TEST(Bifilar, HasTheFormulaOfThePaperWithPiSquared) {
  const double period = 1.95;
  EXPECT_NEAR(mass * inertia_per_mass(reference, period, gravity),
              mass * gravity * 0.2 * 0.2 * period * period / (16.0 * pi * pi * 1.0), 1e-15);
  EXPECT_NEAR(period_at(reference, 0.0), small_period(), 1e-12);
  EXPECT_NEAR(period_at(reference, 1e-4), small_period(), 1e-8);
}

// An oscillation in which each swing has a new random period.
Series no_pendulum() {
  sim::RandomStream random(1, "no swing");
  Series record;
  double phase = 0.0, rate = 3.0, amplitude = 1.0;
  for (int i = 0; i < 2000; ++i) {
    phase += 0.01 * rate;
    if (phase > 2.0 * pi) {
      phase -= 2.0 * pi;
      rate = random.uniform(2.0, 6.0);
    }
    record.add(10'000'000LL * i, amplitude * std::cos(phase));
    amplitude *= 0.9995;
  }
  return record;
}

TEST(Bifilar, AsksWhetherSpacingAndCordAreExchanged) {
  const Bifilar hung{.spacing_above = 0.21, .spacing_below = 0.21, .cord = 1.16};
  const Bifilar exchanged{.spacing_above = 1.16, .spacing_below = 1.16, .cord = 0.21};
  constexpr double period = 2.376;  // of a body of 3 kg and 0.04 kg m²
  EXPECT_THAT(message_of([&] { check_size(exchanged, period, 3.0); }),
              HasSubstr("are --spacing and --cord exchanged?"));
  EXPECT_THAT(message_of([&] { check_size(hung, period, 3e4); }),
              testing::AllOf(HasSubstr("--mass: "), testing::Not(HasSubstr("exchanged"))));
  EXPECT_THAT(message_of([&] { (void)fit_swing(no_pendulum(), exchanged, "swing.log"); }),
              HasSubstr("--from, --to; the cords of 0.21 m are shorter than the 1.16 m that they "
                        "are apart: are --spacing and --cord exchanged?"));
}

TEST(Bifilar, RefusesImpossibleCarsAndCords) {
  const double period = small_period();
  const Bifilar millimetres{.spacing_above = 200, .spacing_below = 200, .cord = 1000};
  const auto refusal = [](const Bifilar& pendulum, double seconds, double kilograms) {
    return message_of([&] { check_size(pendulum, seconds, kilograms); });
  };
  EXPECT_EQ(refusal(reference, period, mass), "");
  EXPECT_EQ(refusal({.spacing_above = 2.0, .spacing_below = 2.0, .cord = 8.0}, 7.4, 1700.0), "");
  EXPECT_THAT(refusal(reference, 0.1 * period, mass), HasSubstr("check --swings, --time"));
  EXPECT_THAT(refusal(millimetres, period, mass), HasSubstr("check --swings, --time"));
  EXPECT_THAT(refusal(reference, period, 1e3 * mass),
              HasSubstr("--mass: 2985 kg does not fit the radius of gyration of 0.097 m"));
  EXPECT_THROW(check({.spacing_above = 0.2, .spacing_below = 2.5, .cord = 1.0}),
               std::invalid_argument);
  EXPECT_THROW((void)lengthening(reference, inertia / mass, 2.0), std::invalid_argument);
}

// The rig simulates a body on springs only: no formula of the pendulum is in it.
double period_of_rig(const sim::SwingParameters& rig) {
  sim::SwingRig car(rig);
  double first = 0.0, last = 0.0;
  int passages = 0;
  for (int i = 0; passages < 4; ++i) {
    const double before = car.output().yaw;
    car.step(1e-3);
    const double after = car.output().yaw;
    if (!(before < 0.0 && after >= 0.0)) continue;
    last = 1e-3 * (i + before / (before - after));
    if (passages++ == 0) first = last;
  }
  return (last - first) / 3.0;
}

sim::SwingParameters ideal_rig() {
  return {.mass = mass,
          .inertia = {0.3 * inertia, 0.9 * inertia, inertia},
          .gravity = gravity,
          .spacing_above = 0.2,
          .spacing_below = 0.2,
          .cord = 1.0,
          .stretch = 1e-3,
          .height_of_attachment = 0.05,
          .amplitude = 0.1};
}

TEST(Bifilar, SwingsAsABodyOnTwoCords) {
  sim::SwingParameters rig = ideal_rig();
  for (const double amplitude : {0.05, 0.2, 0.5}) {
    rig.amplitude = amplitude;
    EXPECT_NEAR(period_of_rig(rig) / period_at(reference, amplitude), 1.0, 3e-4) << amplitude;
  }
  EXPECT_GT(lengthening(reference, inertia / mass, 0.5), 1.01);
}

TEST(Bifilar, SwingsOffCentreAndOnCordsThatAreNotParallel) {
  sim::SwingParameters rig = ideal_rig();
  rig.offset_along = 0.02;
  Bifilar off = reference;
  off.offset = 0.02;
  EXPECT_NEAR(period_of_rig(rig) / period_at(off, 0.1), 1.0, 1e-3);
  rig = ideal_rig();
  rig.spacing_below = 0.24;
  Bifilar spread = reference;
  spread.spacing_below = 0.24;
  EXPECT_NEAR(period_of_rig(rig) / period_at(spread, 0.1), 1.0, 1e-3);
}

Series record_of(const sim::SwingParameters& rig, double seconds, double noise, double bias) {
  sim::SwingRig car(rig);
  sim::RandomStream random(1, "gyro");
  Series series;
  for (int i = 0; i < static_cast<int>(seconds * 100.0); ++i) {
    series.add(1'000'000'000 + 10'000'000LL * i,
               car.output().yaw_rate + bias + noise * random.normal());
    for (int k = 0; k < 10; ++k) car.step(1e-3);
  }
  return series;
}

TEST(SwingFit, FindsTheSmallPeriodOfWideDampedNoisySwings) {
  sim::SwingParameters rig = ideal_rig();
  rig.amplitude = 0.35;
  rig.viscous = 0.01 * inertia;
  rig.quadratic = 0.01 * inertia;
  const SwingFit fit = fit_swing(record_of(rig, 34.0, 0.005, 0.02), reference, "swing.log");
  const double truth = small_period();
  EXPECT_NEAR(fit.period.value / truth, 1.0, 3e-4);
  EXPECT_LT(fit.period.sigma, 3e-4 * truth);
  EXPECT_NEAR(fit.amplitude_begin, 0.35, 0.02);
  EXPECT_NEAR(fit.gyro_bias, 0.02, 1e-3);
  EXPECT_TRUE(fit.warnings.empty());
}

TEST(SwingFit, ReportsARecordInOtherUnits) {
  sim::SwingParameters rig = ideal_rig();
  rig.viscous = 0.01 * inertia;
  rig.amplitude = 0.35;
  const Series swing = record_of(rig, 34.0, 0.005, 0.02);
  const auto refusal = [](const Series& series) {
    return message_of([&] { (void)fit_swing(series, reference, "phone.csv"); });
  };
  Series degrees = swing;
  for (double& value : degrees.value) value *= 180.0 / pi;
  EXPECT_THAT(refusal(degrees), HasSubstr("is that deg/s? Multiply by 0.0174533"));
  Series milliseconds = swing;
  for (std::int64_t& t : milliseconds.t_ns) t *= 1000;
  EXPECT_THAT(refusal(milliseconds), HasSubstr("are they in ms? Divide them by 1000"));
}

TEST(SwingFit, RefusesRecordsWithoutAFreeSwing) {
  Series series;
  sim::RandomStream random(1, "nothing");
  const auto refusal = [&series] {
    return message_of([&] { (void)fit_swing(series, reference, "swing.log"); });
  };
  EXPECT_THAT(refusal(), HasSubstr("swing.log: 0 samples of the yaw rate are too few"));
  for (int i = 0; i < 2000; ++i) {
    series.add(10'000'000LL * i, 0.5);
  }
  EXPECT_THAT(refusal(), HasSubstr("nothing swings"));
  for (double& value : series.value) value = random.normal();
  EXPECT_NE(refusal(), "");
  // Someone turns the car by hand: the rate rises and stays.
  for (std::size_t i = 0; i < series.size(); ++i) series.value[i] = i < 1000 ? 0.0 : 1.0;
  EXPECT_THAT(refusal(), HasSubstr("too few"));
  series = no_pendulum();
  EXPECT_THAT(refusal(), HasSubstr("is not that of a free swing"));
}

TEST(SwingTiming, CorrectsForTheAmplitudeAndRefusesAMiscount) {
  const double small = small_period(), wide = period_at(reference, 0.4);
  const TimedSwing timed = small_period_of({.times = {20.0 * wide, 20.0 * wide},
                                            .swings = 20,
                                            .sigma = 0.1,
                                            .amplitude_begin = 0.4,
                                            .amplitude_end = 0.4},
                                           reference);
  EXPECT_NEAR(timed.period.value, small, 3e-5);
  EXPECT_NEAR(timed.period.sigma, std::hypot(0.1 / std::sqrt(2.0) / 20.0, 0.25 * (wide - small)),
              2e-4);
  const auto refusal = message_of([] {
    (void)small_period_of({.times = {40.0, 42.0}, .swings = 20, .sigma = 0.1}, reference);
  });
  EXPECT_THAT(refusal, HasSubstr("count again"));
}

const std::string hang = "odom identify inertia --mass 2.985 --spacing 0.2 --cord 1 ";

TEST(IdentifyInertia, ByStopWatch) {
  const double period = small_period(9.806);
  const auto json = nlohmann::json::parse(
      must_run(hang + "--amplitude 0 --offset-sigma 0 --json --swings 20 --time " +
               std::to_string(20.0 * period)));
  EXPECT_NEAR(json["values"][0]["value"].get<double>(), inertia, 1e-6);
  EXPECT_EQ(json["values"][0]["key"], "vehicle.yaw_inertia");
  // Independent parts; the period's, relative to J, is 2 · 0.15 s / (20 periods).
  const auto& parts = json["details"]["contributions"];
  EXPECT_NEAR(parts["period"].get<double>(), 2.0 * 0.15 / (20.0 * period) * inertia, 1e-6);
  double variance = 0.0;
  for (const auto& part : parts) variance += part.get<double>() * part.get<double>();
  EXPECT_NEAR(json["values"][0]["sigma"].get<double>(), std::sqrt(variance), 1e-12);
  EXPECT_THAT(json["values"][0]["remark"].get<std::string>(),
              testing::StartsWith("mostly from the period ("));
}

TEST(IdentifyInertia, ByTheGyroOfASimulatedSwing) {
  const Scratch scratch;
  scratch.must_run("odom sim swing --duration 20 --seed 5 --out .  --force");
  const auto truth = nlohmann::json::parse(scratch.text("plant.json"))["experiment"];
  std::string line = "odom identify inertia --json --config car.toml --can drive.log";
  for (const auto& [option, value] : {std::pair{" --mass ", "mass"},
                                      {" --spacing ", "spacing"},
                                      {" --spacing-below ", "spacing_below"},
                                      {" --cord ", "cord"},
                                      {" --gravity ", "gravity"}})
    line += option + truth[value].dump();
  EXPECT_NEAR(
      scratch.json(line)["values"][0]["value"].get<double>() / truth["yaw_inertia"].get<double>(),
      1.0, 0.005);
}

TEST(IdentifyInertia, WarnsIfPassagesWereCounted) {
  const Scratch scratch;
  scratch.write("car.toml", "[vehicle]\nfront_axle = 0.175\nrear_axle = 0.085\n");
  const double period = small_period(9.806);
  for (const auto& [swings, asks] : {std::pair{"10", true}, {"20", false}, {"40", true}}) {
    const Outcome outcome = scratch.run(hang + "--amplitude 0 --config car.toml --time " +
                                        std::to_string(20.0 * period) + " --swings " + swings);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("passages counted instead of full swings") != std::string::npos,
              asks)
        << swings << outcome.err;
  }
}

TEST(IdentifyInertia, SaysWhatIsMissingOrWrong) {
  const Scratch scratch;
  scratch.write("back.csv", "t,yaw_rate\n1,0\n0.5,1\n");
  scratch.write("other.csv", "t,rate\n1,0\n");
  expect_answers(scratch, 2, hang, R"(
 -> give --time and --swings, --csv, or --config and --can
--time 40 -> --swings is missing
--can drive.log -> --can needs --config
--csv back.csv -> back.csv:3: column "t": earlier
--csv other.csv -> yaw_rate
)");
}

}  // namespace
}  // namespace odomd::tools::inertia_test
