// Whole simulated drives: they end, close and repeat, and their frames contain the sensed values.
#include <map>
#include <optional>
#include <tuple>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/sim/drive_folder.hpp"
#include "tools/sim/simulation.hpp"

namespace odomd::sim::sim_drive_test {
namespace {

struct Drive {
  RunPlan plan;
  Happenings all;
  PlantOutput end;
};

Drive drive(const RunOptions& options) {
  Drive result{.plan = make_plan(options), .all = {}, .end = {}};
  Simulation simulation(result.plan);
  while (simulation.advance(simulation.time_ns() + 500'000'000, result.all) == RunState::running) {
    if (simulation.time_ns() > 400'000'000'000) throw std::runtime_error("the drive does not end");
  }
  result.end = simulation.plant().output();
  return result;
}

/// Times and data of all frames, but only the times of the message `but`.
std::vector<std::pair<std::int64_t, std::vector<std::uint8_t>>> sent(const Happenings& all,
                                                                     std::uint32_t but = 0) {
  std::vector<std::pair<std::int64_t, std::vector<std::uint8_t>>> frames;
  for (const can::Frame& frame : all.frames)
    frames.push_back({frame.time_ns, {frame.data.begin(), frame.data.begin() + frame.length}});
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (all.frames[i].id == but) frames[i].second.clear();
  return frames;
}

using enum CarKind;

struct Course {
  const char* scenario;
  std::optional<CarKind> car{};
  std::optional<double> speed{};
};

void PrintTo(const Course& course, std::ostream* out) {
  *out << course.scenario;
}

class EveryDrive : public ::testing::TestWithParam<Course> {};

TEST_P(EveryDrive, EndsStandingWhereItBegan) {
  const auto& [scenario, car, speed] = GetParam();
  const Drive d = drive({.scenario = scenario,
                         .car = car,
                         .speed = speed,
                         .laps = 1,
                         .standstill = 0.5,
                         .seed = car ? 3U : 1U});
  double lateral = 0.0, fastest = 0.0;
  for (const tools::TrajectoryPoint& row : d.all.truth) {
    for (const double value : {row.pose.x, row.pose.y, row.pose.yaw, row.motion.v_x, row.motion.v_y,
                               row.motion.yaw_rate})
      ASSERT_TRUE(std::isfinite(value));
    lateral = std::max(lateral, std::abs(row.motion.v_x * row.motion.yaw_rate));
    fastest = std::max(fastest, row.motion.v_x);
  }
  EXPECT_LT(lateral, 8.5);
  EXPECT_GT(fastest, 0.9 * speed.value_or(0.0));
  EXPECT_EQ(d.end.v_x, 0.0);
  EXPECT_EQ(d.end.yaw_rate, 0.0);
  const double gap = size_of(d.plan.car_kind) != CarSize::full ? 0.04 : car ? 0.5 : 0.4;
  EXPECT_LT(std::hypot(d.end.x - d.plan.start.x, d.end.y - d.plan.start.y), gap);
  EXPECT_NEAR(std::remainder(d.end.yaw - d.plan.start.heading, 6.283185307), 0.0, 0.05);
  // The car is at rest at first, and the stamps increase.
  EXPECT_EQ(d.all.truth[99].pose.x, d.plan.start.x);
  for (std::size_t i = 1; i < d.all.frames.size(); ++i)
    ASSERT_GT(d.all.frames[i].time_ns, d.all.frames[i - 1].time_ns);
}

// Every scenario, and cars with published data on courses of their size, slow and fast.
INSTANTIATE_TEST_SUITE_P(
    Sim, EveryDrive,
    ::testing::Values(Course{"lap"}, Course{"circle"}, Course{"circles"}, Course{"exercise"},
                      Course{"slalom"}, Course{"stop-and-go"}, Course{"parking"}, Course{"patch"},
                      Course{"road"}, Course{"lap", bmw_320i, 22.0},
                      Course{"lap", ford_escort, 22.0}, Course{"lap", vw_vanagon, 22.0},
                      Course{"slalom", bmw_320i, 22.0}, Course{"slalom", ford_escort, 8.0},
                      Course{"slalom", vw_vanagon, 15.0}, Course{"hills", vw_vanagon, 18.0},
                      Course{"banked", bmw_320i, 20.0}, Course{"banked", vw_vanagon, 15.0},
                      Course{"parking", ford_escort, 3.0}, Course{"circle", bmw_320i, 14.0},
                      Course{"stop-and-go", bmw_320i, 15.0}));

TEST(Sim, ACarWithPublishedDataHasItsOwnCycleTimes) {
  const Drive a = drive({.scenario = "slalom", .car = vw_vanagon, .duration = 20.0});
  EXPECT_NEAR(static_cast<double>(std::ranges::count(a.all.frames, 0x1A2U, &can::Frame::id)),
              2000.0, 2.0);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(a.all.frames, 0x1A1U, &can::Frame::id)),
              1000.0, 2.0);
  EXPECT_THAT(bus_database_text(a.plan.truth), HasSubstr("\"GenMsgCycleTime\" BO_ 418 10;"));
  EXPECT_EQ(bus_database_text(make_plan({}).truth), bus_database_text());
}

// Means in the half circles of the oval: lateral specific force, its value on a level road, bank
// and roll.
struct BankedTurn {
  double read = 0.0, level = 0.0, bank = 0.0, roll = 0.0;
};

BankedTurn banked_turn(CarKind car, double bank) {
  Simulation simulation(make_plan({.scenario = "banked",
                                   .car = car,
                                   .laps = 1,
                                   .standstill = 0.0,
                                   .errors = ErrorModel::ideal,
                                   .sizes = {{Parameter::road_bank, bank}}}));
  BankedTurn sum;
  double count = 0.0;
  Happenings happenings;
  while (simulation.advance(simulation.time_ns() + 10'000'000, happenings) == RunState::running) {
    const PlantOutput& out = simulation.plant().output();
    if (out.yaw_rate < 0.9 * out.v_x / 45.0 || out.v_x < 14.0) continue;
    sum.read += specific_force_at(out, 0.0, 0.0).y;
    sum.level += out.v_x * out.yaw_rate;
    sum.bank += out.bank;
    sum.roll += out.roll;
    count += 1.0;
  }
  return {sum.read / count, sum.level / count, sum.bank / count, sum.roll / count};
}

TEST(Sim, TheAccelerometerMeasuresGravityInABankedTurn) {
  constexpr double gravity = 9.80665;
  for (const CarKind car : {bmw_320i, vw_vanagon}) {
    const BankedTurn level = banked_turn(car, 0.0), banked = banked_turn(car, 0.17);
    EXPECT_EQ(level.bank, 0.0);
    EXPECT_NEAR(banked.bank, -0.17, 0.005);
    EXPECT_GT(level.level, 4.0);
    // The body leans outwards, but less on a bank, which takes up a part of the lateral force.
    EXPECT_GT(level.roll, 0.03);
    EXPECT_LT(banked.roll, 0.8 * level.roll);
    for (const BankedTurn& turn : {level, banked})
      EXPECT_NEAR(turn.read, turn.level + gravity * std::sin(turn.bank + turn.roll), 0.06);
  }
}

TEST(Sim, LapsCloseAtEverySpeedAndWithASlowServo) {
  for (const auto& [speed, slow, gap] :
       {std::tuple{1.0, false, 0.05}, {2.0, false, 0.05}, {2.5, false, 0.05}, {2.0, true, 0.1}}) {
    RunOptions options{.scenario = "lap", .speed = speed, .laps = 1, .standstill = 0.0};
    if (slow) options.sizes = slow_servo();
    const Drive d = drive(options);
    EXPECT_LT(std::hypot(d.end.x - d.plan.start.x, d.end.y - d.plan.start.y), gap) << speed;
  }
}

TEST(Sim, AMovingStartNeverStandsStill) {
  const std::array<std::pair<std::string, double>, 3> drives{
      {{"lap", 1.4}, {"circle", 0.9}, {"road", 15.0}}};
  for (const auto& [scenario, slowest] : drives) {
    const Drive d = drive({.scenario = scenario, .laps = 1, .ends = Ends::moving});
    // On the road the driver may slow down for curves.
    for (const tools::TrajectoryPoint& row : d.all.truth)
      EXPECT_GT(row.motion.v_x, 0.5 * slowest) << scenario;
    EXPECT_GT(d.all.truth.front().motion.v_x, slowest) << scenario;
    const double scale = size_of(d.plan.car_kind) == CarSize::full ? 10.0 : 1.0;
    EXPECT_LT(std::hypot(d.end.x - d.plan.start.x, d.end.y - d.plan.start.y), 0.1 * scale);
    // The wheels turn from the first frame on.
    const auto wheels = std::ranges::find(d.all.frames, 0x1A1U, &can::Frame::id);
    EXPECT_NE(std::vector(wheels->data.begin() + 2, wheels->data.begin() + 5),
              std::vector<std::uint8_t>(3, 0))
        << scenario;
  }
  EXPECT_THROW((void)make_plan({.scenario = "parking", .ends = Ends::moving}),
               std::invalid_argument);
}

TEST(Sim, ParkingReversesAndIceMakesSlip) {
  const Drive parking = drive({.scenario = "parking", .laps = 1});
  double slowest = 0.0;
  for (const tools::TrajectoryPoint& row : parking.all.truth)
    slowest = std::min(slowest, row.motion.v_x);
  EXPECT_LT(slowest, -0.3);

  const auto most_slip = [](const Drive& d) {
    double most = 0.0;
    for (const tools::TrajectoryPoint& row : d.all.truth)
      most = std::max(most, std::abs(row.motion.v_y));
    return most;
  };
  const double dry = most_slip(drive({.scenario = "lap", .speed = 1.6, .laps = 1}));
  EXPECT_GT(most_slip(drive({.scenario = "patch", .laps = 1})), 2.0 * dry);
}

TEST(Sim, TheSameSeedGivesTheSameBits) {
  const Drive a = drive({.duration = 6.0, .seed = 11}), b = drive({.duration = 6.0, .seed = 11});
  EXPECT_EQ(sent(a.all), sent(b.all));
  ASSERT_EQ(a.all.truth.size(), b.all.truth.size());
  EXPECT_EQ(a.all.truth.back().pose.x, b.all.truth.back().pose.x);
  ASSERT_EQ(a.all.camera.size(), b.all.camera.size());
  EXPECT_EQ(a.all.camera.back().x, b.all.camera.back().x);

  const Drive other = drive({.duration = 6.0, .seed = 12});
  EXPECT_NE(a.all.frames[100].data, other.all.frames[100].data);
  EXPECT_NE(a.all.truth.back().pose.x, other.all.truth.back().pose.x);
}

TEST(Sim, ErrorsOfOneSensorLeaveTheOthersUnchanged) {
  RunOptions options{.duration = 5.0};
  const Drive with = drive(options);
  options.sizes = {{Parameter::gyro_noise, 0.0}, {Parameter::camera_noise, 0.0}};
  const Drive without = drive(options);
  EXPECT_EQ(sent(with.all, 0x1A2), sent(without.all, 0x1A2));
  EXPECT_EQ(with.all.truth.back().pose.x, without.all.truth.back().pose.x);
}

TEST(Sim, StretchesOfAnyLengthGiveTheSameDrive) {
  const RunPlan plan = make_plan({.duration = 5.0});
  const auto in_stretches = [&plan](std::int64_t stretch_ns) {
    Simulation simulation(plan);
    Happenings all;
    while (simulation.advance(simulation.time_ns() + stretch_ns, all) == RunState::running) {
    }
    return all;
  };
  const Happenings coarse = in_stretches(700'000'000), fine = in_stretches(1'000'000);
  EXPECT_EQ(sent(coarse), sent(fine));
  EXPECT_EQ(coarse.camera.size(), fine.camera.size());
  EXPECT_EQ(coarse.truth.size(), fine.truth.size());
}

// The written configuration fits the written frames: every frame decodes, its protection holds, and
// without errors its values are the truth.
TEST(Sim, FramesDecodeToWhatWasSensed) {
  const tools::Scratch scratch;
  const Drive d = drive(
      {.scenario = "slalom", .duration = 8.0, .standstill = 0.5, .errors = ErrorModel::ideal});
  write_car_files(scratch.path(""), d.plan, {});
  daemon::Config config = daemon::load_config(scratch.path("car.toml"));
  diagnostics::Diagnostics warnings;
  const std::vector<can::Database> databases = daemon::load_databases(config, warnings);
  EXPECT_TRUE(warnings.empty());
  const std::vector<std::string> buses{"can0"};
  can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses);

  const auto truth_at = [&d](std::int64_t time_ns) {
    const std::int64_t begin = d.all.truth.front().t_ns;
    const auto i = static_cast<std::size_t>((time_ns - begin) / truth_period_ns);
    return d.all.truth[std::min(i, d.all.truth.size() - 1)];
  };
  std::array<can::Sample, can::max_samples_per_frame> samples;
  std::map<std::uint16_t, int> count;
  for (const can::Frame& frame : d.all.frames) {
    const can::DecodeResult result = decoder.decode(frame, samples);
    ASSERT_EQ(result.verdict, can::FrameVerdict::decoded);
    for (std::size_t i = 0; i < result.count; ++i) {
      const tools::TrajectoryPoint truth = truth_at(samples[i].time_ns);
      ++count[samples[i].channel];
      switch (static_cast<estimator::Source>(samples[i].channel)) {
        case estimator::Source::yaw_rate:
          EXPECT_NEAR(samples[i].value, truth.motion.yaw_rate, 0.08);  // changes in 5 ms
          break;
        case estimator::Source::wheel_rear_left:
          EXPECT_NEAR(samples[i].value, truth.motion.v_x - 0.08 * truth.motion.yaw_rate,
                      0.12);  // tyre slip
          break;
        case estimator::Source::wheel_rear_right:
          EXPECT_NEAR(samples[i].value, truth.motion.v_x + 0.08 * truth.motion.yaw_rate, 0.12);
          break;
        default:
          break;
      }
    }
  }
  EXPECT_EQ(count.size(), 8U);
  const auto& counters = decoder.counters(0);
  EXPECT_EQ(counters.some_lost.get(), 0U);
}

TEST(Sim, TheFolderHasTheFilesThatTheToolsRead) {
  const tools::Scratch scratch;
  const auto folder = scratch.path("drive");
  make_drive_folder(folder, Existing::keep);
  const Drive d = drive({.duration = 2.0});
  write_car_files(folder, d.plan, {});
  DriveWriter writer(folder, "can0");
  writer.write(d.all);
  writer.close();

  const tools::CameraLog camera = tools::read_camera_log(folder / "camera.csv");
  EXPECT_TRUE(camera.warnings.empty());
  ASSERT_EQ(camera.poses.size(), d.all.camera.size());
  EXPECT_EQ(camera.poses.back().capture_ns, d.all.camera.back().capture_ns);
  EXPECT_NEAR(camera.poses.back().x, d.all.camera.back().x, 1e-6);

  EXPECT_THROW(make_drive_folder(folder, Existing::keep), std::invalid_argument);
  EXPECT_NO_THROW(make_drive_folder(folder, Existing::replace));
  EXPECT_THROW(make_drive_folder(folder / "car.toml", Existing::replace), std::invalid_argument);
}

TEST(Sim, ACarThatSlidesOffTheTrackIsAnError) {
  EXPECT_THROW(
      (void)drive({.scenario = "lap", .speed = 4.0, .fixed = {{Parameter::friction, 0.06}}}),
      std::runtime_error);
}

}  // namespace
}  // namespace odomd::sim::sim_drive_test
