// odom sim as a command.
#include <sys/socket.h>

#include <odom/odom.h>

#include "base/file_descriptor.hpp"
#include "can_protocol/sources/candump.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/unix_socket.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::tools::sim_command_test {
namespace {

std::vector<can::Frame> frames_of(const std::string& text) {
  std::vector<can::Frame> frames;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const can::CandumpLine parsed = can::parse_candump_line(line);
    EXPECT_TRUE(parsed.good()) << line;
    frames.push_back(parsed.frame);
  }
  return frames;
}

TEST(SimCommand, KeepsOtherFilesInTheDirectory) {
  const Scratch scratch;
  scratch.write("precious", "data");
  EXPECT_THAT(scratch.run("odom sim --duration 1 --out ."), Ends(2, HasSubstr("--force")));
  EXPECT_THAT(scratch.run("odom sim --duration 1 --force --out ."), Ends(0, ""));
  EXPECT_EQ(scratch.text("precious"), "data");
}

TEST(SimCommand, JsonHasTheDrawnErrors) {
  const Scratch scratch;
  const auto report = scratch.json(
      "odom sim --json --duration 1 --seed 4 --fix gyro_bias=-0.02 --gyro-scale-error 0 --out .");
  EXPECT_THAT(report,
              Includes(R"({"truth": {"gyro_bias": -0.02, "gyro_scale_error": 0.0}, "seed": 4})"));
  EXPECT_NE(report["truth"]["wheel_radius_error"], 0.0);
  EXPECT_EQ(nlohmann::json::parse(scratch.text("plant.json"))["truth"], report["truth"]);
}

TEST(SimCommand, WeighsAndSwingsTheCarThatItDrives) {
  const Scratch scratch;
  const auto plant_of = [&scratch](const std::string& what, const std::string& seed) {
    scratch.must_run("odom sim " + what + " --force --out made --seed " + seed);
    return nlohmann::json::parse(scratch.text("made/plant.json"));
  };
  // Every drive of the 1:10 car simulates this car, except for the errors of mass and inertia,
  // which its owner measures.
  const sim::PlantParameters car = sim::true_vehicle(sim::CarKind::scale_car, {});
  for (const std::string seed : {"1", "2"}) {
    const auto drawn = plant_of("--duration 2", seed).at("truth");
    const double mass = car.mass * (1.0 + drawn.at("mass_error").get<double>());
    const double inertia = car.yaw_inertia * (1.0 + drawn.at("inertia_error").get<double>());
    const auto weighed = plant_of("weighing", seed).at("experiment");
    EXPECT_DOUBLE_EQ(weighed.at("mass"), mass);
    EXPECT_DOUBLE_EQ(weighed.at("front_axle"), car.front_axle);
    EXPECT_DOUBLE_EQ(weighed.at("rear_axle"), car.rear_axle);
    EXPECT_DOUBLE_EQ(weighed.at("track_width"), car.track_width);
    const auto swung = plant_of("swing --duration 20", seed).at("experiment");
    EXPECT_DOUBLE_EQ(swung.at("mass"), mass);
    EXPECT_DOUBLE_EQ(swung.at("yaw_inertia"), inertia);
  }
}

TEST(SimCommand, WritesMeasurementsThatIdentifyAccepts) {
  const Scratch scratch;
  for (const std::string seed : {"1", "5", "15", "20"}) {
    for (const std::string what : {"weighing", "swing"})
      scratch.must_run("odom sim " + what + " --force --out " + what + " --seed " + seed);
    // The values are rounded like readings.
    for (const auto& [file, name] : {std::pair{"weighing", "wheelbase"},
                                     {"swing", "spacing"},
                                     {"swing", "spacing_below"},
                                     {"swing", "cord"}}) {
      const auto measured =
          nlohmann::json::parse(scratch.text(std::string(file) + "/measured.json"));
      EXPECT_LE(measured.at(name).dump().size(), std::string("0.2195").size()) << name;
    }
    // The mass that the first method stores is an input of the next methods.
    for (const std::string method :
         {"mass --measured weighing", "cog --measured weighing", "inertia --measured swing"})
      EXPECT_THAT(scratch.run("odom identify " + method + "/measured.json --write swing/car.toml"),
                  Ends(0, Not(HasSubstr("contradict"))));
    EXPECT_THAT(scratch.text("swing/car.toml"),
                AllOf(HasSubstr("odom identify mass"), HasSubstr("odom identify cog"),
                      HasSubstr("odom identify inertia")));
  }
}

TEST(SimCommand, ListsItsScenarios) {
  const std::string out = must_run("odom sim --list");
  for (const char* name : {"lap", "circle", "circles", "exercise", "slalom", "stop-and-go",
                           "parking", "patch", "drift", "road", "hills", "banked"})
    EXPECT_THAT(out, HasSubstr(name));
}

TEST(SimCommand, WrongUsageIsOneLineAndStatusTwo) {
  const Scratch scratch;
  for (const std::string line :
       {"", "--scenario nowhere --out x", "--fix nonsense --out x", "--speed 99 --out x",
        "--gyro-noise -1 --out x", "--can can0 --out x", "--live --json",
        "--car bmw_320i --scenario patch --out x", "--car scale --scenario hills --out x",
        "--laps 0 --out x", "--standstill -1 --out x", "--duration nan --out x",
        "--friction 0 --out x", "--fix gyro_bias=-9 --out x", "--start-time x --out x",
        "--live --can nosuchcan --duration 1", "--camera-dropout 3 --out x",
        "--camera-latency-min 1 --out x"})
    EXPECT_THAT(scratch.run("odom sim " + line),
                Ends(2, ::testing::MatchesRegex("odom sim: [^\n]*\n")));
  expect_answers(scratch, 2, "odom sim --out x --fix", R"(
gyro_bais=1 -> the nearest is 'gyro_bias'
gyro_bias -> NAME=VALUE
gyro_bias=1x -> not a finite number
gyro_bias=nan -> not a finite number
foo=1 -> not a parameter of the simulation; available: friction,
)");
  EXPECT_FALSE(std::filesystem::exists(scratch.path("x")));
}

TEST(SimCommand, LiveOnStandardOutputIsTheSameDriveAtAnotherTime) {
  const Scratch scratch;
  const std::string options = "odom sim --duration 1.5 --standstill 0.3 --seed 3 --out ";
  scratch.must_run(options + "offline");
  const std::string played = scratch.must_run(options + "live --live");

  const auto expected = frames_of(scratch.text("offline/drive.log"));
  const auto seen = frames_of(played);
  ASSERT_EQ(seen.size(), expected.size());
  ASSERT_GT(seen.size(), 500U);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].id, expected[i].id);
    EXPECT_EQ(seen[i].data, expected[i].data);
    EXPECT_EQ(seen[i].time_ns - seen[0].time_ns, expected[i].time_ns - expected[0].time_ns);
  }
  EXPECT_EQ(scratch.text("live/drive.log"), played);
}

TEST(SimCommand, LiveFramesAreNotSentBeforeTheirTime) {
  // The receiver stamps the frames: early frames would shift the bus relative to the camera.
  const Outcome played = run_shell(
      "odom sim --live --duration 1 | { IFS= read -r frame; date +'(%s.%N) can0 000#'; "
      "echo \"$frame\"; cat >/dev/null; }");
  const auto frames = frames_of(played.out);
  ASSERT_EQ(frames.size(), 2U) << played.out << played.err;
  EXPECT_GE(frames[0].time_ns, frames[1].time_ns);
}

TEST(SimCommand, EndsWithOneLineWhenItsReaderCloses) {
  const Scratch scratch;
  const Outcome outcome =
      scratch.run("(odom sim --live --duration 20; echo $? > status) | head -n 3");
  EXPECT_EQ(scratch.text("status"), "1\n");
  EXPECT_THAT(outcome.err, HasSubstr("standard output: the reader has gone"));
}

// A live drive that has sent its first frames.
TEST(SimCommand, LeavesCompleteFilesAfterASignalWhateverSignalsFollow) {
  const Scratch scratch;
  for (const std::string more : {"", "kill -TERM $pid; kill -TERM $pid; "})
    EXPECT_THAT(
        scratch.run(
            "rm -rf drive; odom sim --live --out drive >/dev/null & pid=$!; i=0; "
            "until [ -s drive/drive.log ] || [ $((i += 1)) -gt 1200 ]; do sleep 0.05; done; "
            "kill -INT $pid; " +
            more +
            "wait $pid && odom replay --config drive/car.toml --can drive/drive.log "
            "--out pose.csv"),
        Ends(0, HasSubstr("interrupted")));
}

TEST(SimCommand, SendsCameraPosesToTheSocket) {
  const Scratch scratch;
  const std::string path = scratch.path("camera.sock").string();
  const FileDescriptor door = listening_socket(path, SOCK_SEQPACKET);
  scratch.must_run(
      "odom sim --live --duration 1 --camera-socket camera.sock --out drive >/dev/null");
  EXPECT_THAT(scratch.text("drive/car.toml"), HasSubstr(path));

  const FileDescriptor connection(::accept(door.get(), nullptr, nullptr));
  ASSERT_TRUE(connection);
  std::size_t messages = 0;
  odom_camera_message message{};
  while (::recv(connection.get(), &message, sizeof message, 0) ==
         static_cast<ssize_t>(sizeof message)) {
    ++messages;
    EXPECT_EQ(message.magic, ODOM_CAMERA_MAGIC);
    EXPECT_EQ(message.clock, ODOM_CLOCK_LOG);
    EXPECT_NEAR(message.sigma_x, 0.008, 1e-12);
  }
  const std::string log = scratch.text("drive/camera.csv");
  EXPECT_EQ(messages + 1, static_cast<std::size_t>(std::count(log.begin(), log.end(), '\n')));
  EXPECT_GT(messages, 20U);
}

}  // namespace
}  // namespace odomd::tools::sim_command_test
