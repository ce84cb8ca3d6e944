// odom identify stiffness on a simulated afternoon, and what it says of one gone wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::stiffness_command_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// One drive for all of them.
const std::string& afternoon() {
  static const Scratch scratch;
  static const std::string folder = [] {
    const std::string made = scratch.path("circles").string();
    const Outcome outcome = run_shell(
        "odom sim --scenario circles --markers --seed 3 --fix mass_error=0 --out " + made);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return made;
  }();
  return folder;
}

Outcome identify(const std::string& options) {
  return run_shell("cd " + afternoon() + " && odom identify stiffness --config car.toml " +
                   options);
}

const std::string places = "--front 0.18,0 --rear -0.12,0 ";
const std::string film = "--y-down --run markers.csv,drive.log ";

std::string contents(const std::string& file) {
  return tools::contents(afternoon() + "/" + file);
}

void write(const std::string& file, const std::string& text) {
  std::ofstream(afternoon() + "/" + file) << text;
}

TEST(StiffnessCommand, TheTruthLiesWithinTwoSigmaAndGoesIntoTheConfiguration) {
  std::filesystem::copy_file(afternoon() + "/car.toml", afternoon() + "/mine.toml");
  const Outcome outcome = identify(places + film + "--json --plot tyres.svg --write mine.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err,
            "odom identify stiffness: 2 keys written to mine.toml: "
            "vehicle.cornering_stiffness_front, vehicle.cornering_stiffness_rear\n");
  const auto json = nlohmann::json::parse(outcome.out);
  const auto truth = nlohmann::json::parse(contents("plant.json"))["truth"];
  const double front = 20.0 * (1.0 + truth["stiffness_error_front"].get<double>());
  const double rear = 60.0 * (1.0 + truth["stiffness_error_rear"].get<double>());
  EXPECT_NEAR(json["values"][0]["value"], front, 2.0 * json["values"][0]["sigma"].get<double>());
  EXPECT_NEAR(json["values"][1]["value"], rear, 2.0 * json["values"][1]["sigma"].get<double>());
  EXPECT_LT(json["values"][0]["sigma"].get<double>(), 0.025 * front);
  EXPECT_LT(json["values"][1]["sigma"].get<double>(), 0.025 * rear);
  EXPECT_EQ(json["details"]["circles"].size(), 12U);
  EXPECT_THAT(contents("mine.toml"), HasSubstr("odom identify stiffness"));
  EXPECT_THAT(contents("tyres.svg"), HasSubstr("</svg>"));
}

/// With a car whose `signal` has another scale.
Outcome identify_scaled(const std::string& signal, const std::string& scale) {
  std::string text = contents("car.toml");
  const std::string entry = "signal = " + signal;
  text.insert(text.find(entry) + entry.size(), ", scale = " + scale);
  write("scaled.toml", text);
  return run_shell("cd " + afternoon() + " && odom identify stiffness --config scaled.toml " +
                   places + film);
}

TEST(StiffnessCommand, AFilmWhoseScaleTheAccelerometerContradictsGivesAWarning) {
  EXPECT_THAT(identify_scaled("\"AccY\", unit = \"m/s2\"", "1.05"),
              Ends(0, HasSubstr("% of the film's lateral acceleration")));
}

TEST(StiffnessCommand, WhatTheCirclesContradictIsNotWritten) {
  const auto expect = [](const std::string& options, const std::string& reason) {
    const std::string car = contents("car.toml");
    write("kept.toml", car);
    const Outcome outcome = identify(options + film + "--json --write kept.toml");
    EXPECT_EQ(outcome.status, 0) << options << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(reason)) << options;
    const auto json = nlohmann::json::parse(outcome.out);
    for (std::size_t axle = 0; axle < 2; ++axle)
      EXPECT_EQ(json["values"][axle]["determined"], false) << options;
    EXPECT_EQ(contents("kept.toml"), car) << options;
    EXPECT_THAT(outcome.err, HasSubstr("nothing written to kept.toml")) << options;
  };
  // Measured from the rear marker, the front one, the middle of the wheelbase.
  expect("--front 0.30,0 --rear 0,0 ",
         "centre of gravity lies 0.120 m ahead of the place in --front and");
  expect("--front 0,0 --rear -0.30,0 ", "centre of gravity lies 0.180 m behind the place");
  expect("--front 0.225,0 --rear -0.075,0 ", "centre of gravity lies 0.045 m ahead of");
  // A minus forgotten.
  expect("--front 0.18,0 --rear 0.12,0 ", "of the film's lateral acceleration, and one of the two");
  expect("--front 0.18,0 --rear 0.12,0 ", "no marker lies behind the centre of gravity");
  expect("--front 0.36,0 --rear -0.24,0 ", "accelerometer reads 50 %");
}

TEST(StiffnessCommand, ASteeringOfAnotherScaleIsRefusedOrContradicted) {
  const auto with_scale = [](const std::string& scale) {
    return identify_scaled("\"SteeringAngle\", unit = \"rad\"", scale);
  };
  for (const char* scale : {"17", "0.0588"}) {
    EXPECT_THAT(with_scale(scale),
                Ends(2, HasSubstr("correct scale and unit of [can.signals] steering")));
  }
  const Outcome contradicted = with_scale("1.5");
  EXPECT_EQ(contradicted.status, 0);
  EXPECT_THAT(contradicted.err, HasSubstr("is 1.47 times the angle of the wheels"));
  EXPECT_THAT(contradicted.out, HasSubstr("not determined"));
}

TEST(StiffnessCommand, SaysWhereItIsLessExactThanItCouldBe) {
  EXPECT_THAT(identify(places + film + "--sigma-mass 0.15"),
              Ends(0, HasSubstr("and 5 % is possible; drive faster circles")));
}

TEST(StiffnessCommand, TakesUnits) {
  const std::string sigmas = "--sigma-mass 0.015 --sigma-axle 0.001 --sigma-marker 0.001";
  const Outcome plain = identify(places + film + sigmas);
  const Outcome units = identify("--front 18cm,0 --rear -120mm,0 " + film +
                                 "--sigma-mass 15g --sigma-axle 1mm --sigma-marker 0.1cm");
  EXPECT_EQ(plain.status, 0) << plain.err;
  EXPECT_EQ(units.out, plain.out);
}

TEST(StiffnessCommand, EachMistakeIsOneLineThatSaysWhatToDo) {
  std::string text = contents("car.toml");
  text.erase(text.find("[vehicle]"), text.find("[can]") - text.find("[vehicle]"));
  write("no_car.toml", text);
  // Only the slowest circles, and markers that nobody has measured.
  std::string slow;
  std::istringstream lines(contents("markers.csv"));
  for (std::string line; std::getline(lines, line) && line.rfind("55.", 0) != 0;)
    slow += line + '\n';
  write("slow.csv", slow);
  const std::pair<std::string, const char*> cases[]{
      {places + "--run markers.csv,drive.log", "--y-down"},
      {"--front -0.12,0 --rear 0.18,0 " + film, "markers are swapped"},
      {"--front 0,0.18 --rear 0,-0.12 " + film, "the car moves sideways"},
      {"--front 0.18 --rear -0.12,0 " + film, "--front"},
      {"--front 18apples,0 --rear -0.12,0 " + film, "--front"},
      {places + film + "--sigma-mass 15mm", "--sigma-mass"},
      {places + film + "--sigma-scale 30%", "30% is too much"},
      {places + film + "--sigma-scale 0.3", "write per cent as 0.3%"},
      {places + "--y-down --run markers.csv", "neither MARKERS,LOG"},
      {places + "--y-down --run nothing.csv,drive.log", "no such file"},
      {places + film + "--metres-per-pixel 0.005", "correct the scale"},
      {places + film + "--time-offset 500", "do not overlap"},
      {places + film + "--plot tyres.jpg", ".svg"},
      {places + "--y-down --sigma-marker 0.02 --run slow.csv,drive.log", "too slow"},
      {places + film + "--config no_car.toml", "[vehicle] mass is missing"}};
  for (const auto& [options, reason] : cases)
    expect_refused("cd " + afternoon() + " && odom identify stiffness " +
                       (options.find("--config") == std::string::npos ? "--config car.toml " : ""),
                   {{options, AllOf(StartsWith("odom identify stiffness: "), HasSubstr(reason))}});
}

}  // namespace
}  // namespace odomd::tools::stiffness_command_test
