#include "tools/config_patch/config_patch.hpp"

#include <sys/stat.h>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::config_patch_test {
namespace {

std::string patch(const std::string& text, const std::vector<ConfigValue>& values) {
  std::string once = patched(text, "car.toml", values);
  EXPECT_EQ(patched(once, "car.toml", values), once) << "twice is not once";
  return once;
}

std::string refusal(const std::string& text, const ConfigValue& value) {
  return message_of([&] { (void)patched(text, "car.toml", std::span(&value, 1)); });
}

const std::string note = "odom identify mass: +- 0.1 kg";

TEST(ConfigPatch, ReplacesANumberInPlaceAndKeepsEverythingElse) {
  EXPECT_EQ(patch("# my car\n[vehicle]\n  mass=2.985 # kg\n\n\n[can]\nmass = 7\n",
                  {{"vehicle.mass", 3.1, ""}}),
            "# my car\n[vehicle]\n  mass=3.1 # kg\n\n\n[can]\nmass = 7\n");
  EXPECT_EQ(patch("[vehicle]\nmass = 2\n[can]\nmass = 7", {{"can.mass", 0.1, ""}}),
            "[vehicle]\nmass = 2\n[can]\nmass = 0.1");
  // Numbers get the shortest form that reads back as the same value.
  EXPECT_EQ(patch("a = 1", {{"a", 2.0, ""}}), "a = 2.0");
  EXPECT_EQ(patch("a = +1_0", {{"a", 0.1 + 0.2, ""}}), "a = 0.30000000000000004");
  EXPECT_EQ(patch("a = 0x1F", {{"a", -1e-7, ""}}), "a = -1e-07");
  EXPECT_EQ(patch("a = inf", {{"a", 1e300, ""}}), "a = 1e+300");
  // A number that is too long for its column moves the comment.
  EXPECT_EQ(patch("a = 1 # x", {{"a", 12.345, ""}}), "a = 12.345 # x");
}

TEST(ConfigPatch, AppendsTheNoteToAnExistingComment) {
  const std::string once = patch("[vehicle]\nmass = 2.985   # kg\n", {{"vehicle.mass", 3, note}});
  EXPECT_EQ(once, "[vehicle]\nmass = 3.0     # kg (" + note + ")\n");
  // The comment's column and the text after the note are kept; the earlier note is replaced.
  const std::string later = once.substr(0, once.size() - 1) + " and more\n";
  EXPECT_EQ(patch(later, {{"vehicle.mass", 3.25, "odom identify fit: (good)"}}),
            "[vehicle]\nmass = 3.25    # kg (odom identify fit: [good]) and more\n");
  EXPECT_EQ(patch(later, {{"vehicle.mass", 3.25, ""}}),
            "[vehicle]\nmass = 3.25    # kg  and more\n");
  EXPECT_EQ(patch("a = 1  ", {{"a", 2, note}}), "a = 2.0  # (" + note + ")");
  EXPECT_EQ(patch("a = 1# (mine)", {{"a", 2, note}}), "a = 2.0# (mine) (" + note + ")");
}

TEST(ConfigPatch, ReadsANumberWithItsNoteBack) {
  const std::string text =
      patch("[imu]\nposition = [1, 2]  # where (odom knows)\n[vehicle]\nmass = 3 # kg (odometer)\n",
            {{"imu.position[1]", 0.5, note}});
  const auto there = [&](const std::string& key) { return value_in(text, "car.toml", key); };
  EXPECT_EQ(there("imu.position[1]")->value, 0.5);
  EXPECT_EQ(there("imu.position[1]")->note, note);
  EXPECT_EQ(there("imu.position[0]")->value, 1.0);
  EXPECT_EQ(there("imu.position[0]")->note, "");
  EXPECT_EQ(there("vehicle.mass")->note, "");
  EXPECT_FALSE(there("vehicle.front_axle"));
  EXPECT_THROW((void)there("vehicle"), std::invalid_argument);
}

TEST(ConfigPatch, ReadsTheNumberOfAKeyAndRefusesOtherValues) {
  const Scratch scratch;
  const auto file = scratch.write(
      "car.toml",
      "[imu]\nposition = [0.25, 1]\n[can.signals]\nyaw_rate = { sigma = 3e-2, message = \"M\" }\n");
  EXPECT_EQ(value_in(file, "can.signals.yaw_rate.sigma")->value, 0.03);
  EXPECT_EQ(value_in(file, "imu.position[1]")->value, 1.0);
  EXPECT_FALSE(value_in(file, "filter.wheel_slip"));
  EXPECT_EQ(message_of([&] { (void)value_in(file, "can.signals.yaw_rate.message"); }),
            file.string() +
                ":4: [can.signals.yaw_rate] message: is not a number; correct it, or give another "
                "key");
}

TEST(ConfigPatch, ReachesIntoInlineTablesAndTheNoteSaysWhichNumber) {
  const std::string text =
      "[can.signals]\nyaw_rate = { message = \"I#M\", sigma = 0.03, latency = 0 } # gyro\n";
  const std::string once =
      patch(text, {{"can.signals.yaw_rate.sigma", 0.02, "odom identify noise: a"},
                   {"can.signals.yaw_rate.latency", 0.01, "odom identify latency: b"}});
  EXPECT_EQ(once,
            "[can.signals]\nyaw_rate = { message = \"I#M\", sigma = 0.02, latency = 0.01 } # gyro "
            "(sigma: odom identify noise: a) (latency: odom identify latency: b)\n");
  EXPECT_EQ(patch(once, {{"can.signals.yaw_rate.sigma", 0.5, "odom identify noise: c"}}),
            "[can.signals]\nyaw_rate = { message = \"I#M\", sigma = 0.5, latency = 0.01 } # gyro "
            "(sigma: odom identify noise: c) (latency: odom identify latency: b)\n");
}

TEST(ConfigPatch, ReachesIntoListsEvenOfSeveralLines) {
  EXPECT_EQ(patch("[camera]\nlever_arm = [0, 1.5,2] # x\n", {{"camera.lever_arm[1]", -0.25, note}}),
            "[camera]\nlever_arm = [0, -0.25,2] # x ([1]: " + note + ")\n");
  const std::string lines = "[camera]\nlever_arm = [ # all\n  0.0, # x\n\t1,\n  2.0\n]\n";
  EXPECT_EQ(patch(lines, {{"camera.lever_arm[0]", 5, note}, {"camera.lever_arm[1]", 6, note}}),
            "[camera]\nlever_arm = [ # all\n  5.0, # x ([0]: " + note +
                ")\n\t6.0,  # ([1]: " + note + ")\n  2.0\n]\n");
  EXPECT_EQ(patch("[filter]\n", {{"filter.paper_r[0]", 2.5e-4, ""}}),
            "[filter]\npaper_r = [0.00025, 0.1]\n");  // the other element has its default
  EXPECT_EQ(patch("[filter]\n", {{"filter.paper_q[2]", 1, ""}}),
            "[filter]\npaper_q = [0.05, 0.01, 1.0]\n");
  EXPECT_EQ(patch("[camera]\n", {{"camera.lever_arm[0]", 1, ""}, {"camera.lever_arm[2]", 3, ""}}),
            "[camera]\nlever_arm = [1.0, 0.0, 3.0]\n");
  EXPECT_EQ(patch("", {{"imu.position[1]", 1, ""}}), "[imu]\nposition = [0.0, 1.0]\n");
}

TEST(ConfigPatch, AddsAKeyBelowTheLastOfItsTableAndATableAtTheEnd) {
  EXPECT_EQ(patch("[vehicle]\n  mass = 1 # kg\n  front_axle = [\n  1,\n  2]\n\n[can]\nx = 1\n",
                  {{"vehicle.rear_axle", 2, note}}),
            "[vehicle]\n  mass = 1 # kg\n  front_axle = [\n  1,\n  2]\n  rear_axle = 2.0  # (" +
                note + ")\n\n[can]\nx = 1\n");
  EXPECT_EQ(patch("[vehicle] # empty\n[can]", {{"vehicle.mass", 2, ""}}),
            "[vehicle] # empty\nmass = 2.0\n[can]");
  EXPECT_EQ(patch("\t[vehicle]\n", {{"vehicle.mass", 2, ""}}), "\t[vehicle]\n\tmass = 2.0\n");
  EXPECT_EQ(patch("[vehicle]\nmass = 2", {{"vehicle.x", 3, ""}}), "[vehicle]\nmass = 2\nx = 3.0");
  EXPECT_EQ(patch("[can]\nx = 1", {{"vehicle.mass", 2, note}, {"vehicle.front_axle", 3, ""}}),
            "[can]\nx = 1\n\n[vehicle]\nmass = 2.0  # (" + note + ")\nfront_axle = 3.0\n");
  EXPECT_EQ(patch("[a]\nx = 1\n", {{"a.b.c", 2, ""}}), "[a]\nx = 1\n\n[a.b]\nc = 2.0\n");
  // Adds numbers to inline tables.
  EXPECT_EQ(patch("[s]\ny = { m = \"ü\" }\n", {{"s.y.sigma", 1, ""}}),
            "[s]\ny = { m = \"ü\", sigma = 1.0 }\n");
  EXPECT_EQ(patch("s = {y={m=1}, z = {}}", {{"s.y.x", 1, ""}, {"s.z.x", 2, ""}, {"s.w.v", 3, ""}}),
            "s = {y={m=1, x = 1.0}, z = { x = 2.0 }, w.v = 3.0}");
}

TEST(ConfigPatch, RefusesShapesThatItDoesNotWrite) {
  const ConfigValue sigma{"s.y.sigma", 4, ""};
  for (const char* text : {"s.y.m = 'a'\n", "[s]\ny.m = 'a'\nz.m = 'b'\n", "[s.y.z]\nm = 'a'\n"})
    EXPECT_EQ(refusal(text, sigma),
              "car.toml: [s.y] sigma: cannot be inserted into this text; write 4.0 there by hand");
  EXPECT_EQ(
      patch("vehicle.mass = 1\nvehicle.\"front_axle\" = 2 # m\n", {{"vehicle.front_axle", 3, ""}}),
      "vehicle.mass = 1\nvehicle.\"front_axle\" = 3.0 # m\n");
}

TEST(ConfigPatch, KeepsForeignLineEndsTabsAndMarks) {
  EXPECT_EQ(patch("[vehicle]\r\nmass = 1\t# kg\r\n[x]\r\n",
                  {{"vehicle.mass", 2.5, note}, {"vehicle.y", 1, ""}, {"z.a", 1, note}}),
            "[vehicle]\r\nmass = 2.5\t# kg (" + note +
                ")\r\ny = 1.0\r\n[x]\r\n\r\n[z]\r\na = 1.0  # (" + note + ")\r\n");
  EXPECT_EQ(patch("\xef\xbb\xbf[a]\nmass = 1", {{"a.mass", 2, ""}}), "\xef\xbb\xbf[a]\nmass = 2.0");
  EXPECT_EQ(patch("a = { t = \"äöü€😀\", x = 1 }", {{"a.x", 2, ""}}),
            "a = { t = \"äöü€😀\", x = 2.0 }");
}

TEST(ConfigPatch, IsNotFooledByTexts) {
  const std::string text =
      "[a]\nt = \"\"\"\n[vehicle]\nmass = 1 # no\"\" \\\"\"\"\"\nu = '''\n# ' '''\nv = '#' # yes\n";
  EXPECT_EQ(patch(text + "[vehicle]\nmass = 1\n", {{"vehicle.mass", 2, note}}),
            text + "[vehicle]\nmass = 2.0  # (" + note + ")\n");
  EXPECT_THAT(refusal("a = { x = 1, t = \"\"\"b\nc\"\"\" } # d\n", {"a.x", 2, "odom e"}),
              HasSubstr("cannot be inserted into this text"));
}

TEST(ConfigPatch, ReportsWhatItCannotDo) {
  EXPECT_THAT(refusal("\nmass = [", {"mass", 1, ""}), HasSubstr("car.toml:2: not TOML"));
  EXPECT_EQ(refusal("[vehicle]\nmass = \"3\"", {"vehicle.mass", 1, ""}),
            "car.toml:2: [vehicle] mass: is not a number; correct it");
  EXPECT_EQ(refusal("vehicle = 3", {"vehicle.mass", 1, ""}),
            "car.toml:1: [vehicle] mass: is inside a value that is not a table");
  EXPECT_EQ(refusal("[camera]\nlever_arm = [1, 2]", {"camera.lever_arm[2]", 1, ""}),
            "car.toml:2: [camera] lever_arm[2]: the list has 2 elements only");
  EXPECT_EQ(refusal("[camera]", {"camera.other[2]", 1, ""}),
            "car.toml: [camera] other[2]: there is no such list; give the whole list");
  EXPECT_EQ(refusal("", {"vehicle.mass", std::nan(""), ""}),
            "car.toml: [vehicle] mass: nan cannot be written");
}

constexpr std::string_view car =
    "[can]\nsource = \"can0\"\ndbc = \"car.dbc\"\n"
    "[can.signals]\nwheel_rear = { message = \"W\", signal = \"S\", "
    "unit = \"m/s\" }\n";

TEST(ConfigPatch, OfAFileKeepsItsModeAndLinks) {
  const Scratch scratch;
  const auto file = scratch.write("car.toml", car);
  ASSERT_EQ(::chmod(file.c_str(), 0640), 0);
  std::filesystem::create_symlink("car.toml", scratch.path("link.toml"));
  const std::vector<ConfigValue> values{{"can.signals.wheel_rear.sigma", 0.25, note}};
  patch_config(scratch.path("link.toml"), values);
  EXPECT_THAT(contents(file), HasSubstr("unit = \"m/s\", sigma = 0.25 }  # (sigma: " + note));
  EXPECT_TRUE(std::filesystem::is_symlink(scratch.path("link.toml")));
  EXPECT_EQ(static_cast<unsigned>(std::filesystem::status(file).permissions()), 0640U);
}

TEST(ConfigPatch, OfAFileIsCompleteOrNotDoneAndDoesNotWaitForAPipe) {
  const Scratch scratch;
  const auto file = scratch.write("car.toml", car);
  const std::vector<ConfigValue> values{{"can.signals.wheel_rear.sigma", 0.25, note},
                                        {"can.signals.wheel_rear.latency", -1e9, note}};
  const std::string what = message_of([&] { patch_config(file, values); });
  EXPECT_THAT(what, HasSubstr(file.string() + ":5: [can.signals] wheel_rear"));
  EXPECT_THAT(what, HasSubstr("nothing was written"));
  EXPECT_EQ(contents(file), car);
  const std::filesystem::directory_iterator entries(file.parent_path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1);

  EXPECT_THAT(
      message_of([&] { patch_config(scratch.path("no.toml"), values); }),
      HasSubstr("no.toml: there is no such file; --write changes an existing configuration"));
  must_run("mkfifo " + scratch.path("pipe").string());
  EXPECT_THAT(message_of([&] { check_patchable(scratch.path("pipe")); }),
              HasSubstr("is not a regular file"));
}

}  // namespace
}  // namespace odomd::tools::config_patch_test
