// Sources that a drive does not use are named with the reason.
#include <functional>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::unused_sources_test {
namespace {

using testing::Each;

/// A copy of a sound drive, to be modified.
class Copy : public Scratch {
 public:
  Copy() {
    static const SharedDrive sound{"--seed 3 --duration 20"};
    std::filesystem::copy(sound.folder, path(""));
  }
  void change(const std::string& file, const std::string& what, const std::string& by) const {
    std::string all = text(file);
    const std::size_t at = all.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    write(file, all.replace(at, what.size(), by));
  }
  /// "W322 camera: text" for each diagnostic.
  [[nodiscard]] std::vector<std::string> replayed() const {
    std::vector<std::string> all;
    const std::string errors = run("odom replay --json --drive . --out pose.csv").err;
    const auto result = nlohmann::json::parse(errors.substr(0, errors.find('\n')));
    EXPECT_EQ(result["warnings"].size(), result["diagnostics"].size());
    for (const auto& one : result["diagnostics"])
      all.push_back(one["code"].get<std::string>() + ' ' + one["subject"].get<std::string>() +
                    ": " + one["seen"].get<std::string>() + "; " + one["fix"].get<std::string>());
    return all;
  }
};

struct Case {
  std::string what;
  std::function<void(const Copy&)> spoil;
  std::string code, said;
};

const std::vector<Case> cases{
    {"every camera pose is too old",
     [](const Copy& drive) {
       drive.change("car.toml", "[camera]", "[camera]\nmax_latency = 0.005");
     },
     "W322 camera: all of its", "camera.max_latency"},
    {"a quarter of the camera poses arrive late",
     [](const Copy& drive) {
       drive.must_run(
           "awk -F, -v OFS=, 'NR>1 && NR%4==0 {$1=sprintf(\"%.6f\", $2+0.5)} {print}' "
           "camera.csv >c && mv c camera.csv");
     },
     "W322 camera: ", "too_old"},
    {"poses that come three times",
     [](const Copy& drive) {
       drive.must_run(
           "awk 'NR==1 {print; next} {print; print; print}' camera.csv >c && mv c camera.csv");
     },
     "W322 camera: ", "duplicate"},
    {"a wheel that is never valid",
     [](const Copy& drive) {
       drive.change("car.toml", "signal = \"WheelRearLeft\"",
                    "signal = \"WheelRearLeft\", valid_when = { signal = \"WHEELS_REAR_Counter\", "
                    "equals = 15 }");
     },
     "W322 wheel_rear_left (WHEELS_REAR): it gave no value", "valid_when"},
    {"a gyro that is rarely valid",
     [](const Copy& drive) {
       drive.change("car.toml", "signal = \"YawRate\"",
                    "signal = \"YawRate\", valid_when = { signal = \"IMU_Counter\", equals = 3 }");
     },
     "W322 yaw_rate (IMU): it gave no value", "timeout"},
    {"a steering that comes for half of the drive",
     [](const Copy& drive) {
       drive.must_run("awk '!/ 1A3#/ || NR%6000<3000' drive.log >l && mv l drive.log");
     },
     "W322 steering (STEERING): it gave no value", "rate of its frames"},
    {"a message whose protection always fails",
     [](const Copy& drive) { drive.change("car.toml", "data_id = 419", "data_id = 7"); },
     "W204 message 'STEERING' (steering)", "failed their protection"},
    {"a message that is not in the log",
     [](const Copy& drive) { drive.must_run("grep -v ' 1A3#' drive.log >l && mv l drive.log"); },
     "W203 message 'STEERING' (steering)", "no frame of it"},
    {"every seventh wheel sample is nonsense",
     [](const Copy& drive) {
       drive.change("car.toml", "WHEELS_REAR = {", "WHEELS_FRONT = {");
       drive.change("car.toml", "WHEELS_FRONT = {", "# ");
       drive.change("car.toml", "\nWHEELS_FRONT = {", "\n# ");
       drive.must_run(
           "awk '/ 1A1#/ && ++n%7==0 {sub(/#.*/, \"#0000404B4C404B4C\")} {print}' drive.log "
           ">l && mv l drive.log");
     },
     "W317 wheel_rear_left", "were gated"},
};

TEST(UnusedSources, AreNamedWithTheReason) {
  for (const Case& one : cases) {
    SCOPED_TRACE(one.what);
    const Copy drive;
    one.spoil(drive);
    EXPECT_THAT(drive.replayed(), Contains(AllOf(HasSubstr(one.code), HasSubstr(one.said))));
    EXPECT_NE(drive.json("odom evaluate --drive . --json")["drives"][0]["verdict"]["grade"],
              "good");
    // For gated wheels, doctor names the cause.
    EXPECT_THAT(
        drive.run("odom doctor --drive .").out,
        HasSubstr(one.code.starts_with("W317") ? "wheel_rear_left" : one.code.substr(0, 4)));
  }
}

TEST(UnusedSources, AreNoneInASoundDriveNorWithoutASteering) {
  const Copy drive;
  EXPECT_THAT(drive.replayed(), Each(Not(testing::AnyOf(HasSubstr("W322"), HasSubstr("W317")))));
  // Without steering, the kinematic model is no baseline.
  EXPECT_THAT(drive.run("odom evaluate --drive . --json").out, HasSubstr("that of kinematic"));
  drive.change("car.toml", "\nsteering = {", "\n# ");
  EXPECT_THAT(drive.run("odom evaluate --drive . --json").out, Not(HasSubstr("that of kinematic")));
}

TEST(UnusedSources, LogOfAnotherCarIsOneFinding) {
  const Copy drive;
  drive.must_run("sed 's/ 1A/ 2B/' drive.log >l && mv l drive.log");
  const auto lines = drive.replayed();
  EXPECT_THAT(lines, Contains(HasSubstr("none of the 4 mapped messages is among the ")));
  EXPECT_THAT(lines, Each(Not(HasSubstr("W203"))));
  EXPECT_THAT(drive.run("odom evaluate --drive .").err, HasSubstr("none of the 4 mapped messages"));
  EXPECT_THAT(drive.run("odom doctor --drive .").out, HasSubstr("none of the 4 mapped messages"));
}

TEST(UnusedSources, CameraOfAnotherTimeIsOneFinding) {
  const Copy drive;
  drive.must_run(
      "awk -F, -v OFS=, 'NR>1 {$1=sprintf(\"%.6f\", $1-1e3); $2=sprintf(\"%.6f\", $2-1e3)} "
      "{print}' camera.csv >c && mv c camera.csv");
  const auto lines = drive.replayed();
  EXPECT_THAT(lines, AllOf(Contains(HasSubstr("W407 camera")), Each(Not(HasSubstr("W322")))));
}

TEST(UnusedSources, EstimatesMayEndAMomentApart) {
  const Copy drive;
  drive.must_run(
      "odom replay --config car.toml --can drive.log --camera camera.csv --out pose.csv");
  for (const auto& [rows, differs] : {std::pair{2, false}, {600, true}}) {
    drive.must_run("head -n -" + std::to_string(rows) + " pose.csv >other.csv");
    EXPECT_EQ(drive.run("odom evaluate --reference truth.csv --pose pose.csv --pose other.csv")
                      .err.find("its common time differs") != std::string::npos,
              differs)
        << rows;
  }
}

// A very uncertain heading is not graded "good", however small its error is.
TEST(UnusedSources, UncertainHeadingIsNotGood) {
  const Copy drive;
  drive.must_run(
      "odom replay --config car.toml --can drive.log --camera camera.csv --out pose.csv");
  for (const auto& [degrees, is_uncertain] : {std::pair{9.0, false}, {11.0, true}}) {
    drive.must_run("awk -F, -v OFS=, 'NR>1 {$10=" + std::to_string(degrees * 3.14159265 / 180.0) +
                   "} {print}' pose.csv >other.csv");
    const Outcome outcome =
        drive.run("odom evaluate --reference truth.csv --pose other.csv --json");
    EXPECT_EQ(outcome.out.find("Its heading is uncertain") != std::string::npos, is_uncertain)
        << degrees;
  }
}

}  // namespace
}  // namespace odomd::tools::unused_sources_test
