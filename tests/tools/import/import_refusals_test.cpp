// odom import: whatever is not a table of a drive is refused in one line, and no file is left.
#include <filesystem>
#include <optional>

#include "tests/gtest.hpp"
#include "tests/tools/import/importing.hpp"

namespace odomd::tools::import_refusals_test {
namespace {

struct Case {
  std::string what;
  std::optional<std::string> table;  ///< a.csv
  std::string options, message;
  std::vector<TextFile> others{};
};

const std::string motor = "--column motor=v ";
const std::string pose = "--column camera.x=a --column camera.y=a --column camera.yaw=a ";

const std::vector<Case> cases{
    {"time that runs back", "t,v\n1,1\n1.1,1\n1.05,1\n", motor,
     "a.csv:4: the time runs back by 0.050000 s"},
    {"an unknown column", "t,speed_x,speed_y\n1,1,1\n", "--column motor=sped_x",
     "no column \"sped_x\"; the nearest is 'speed_x'"},
    {"an unknown column for the time", "tick,v\n1,1\n", motor + "--time tik",
     "no column \"tik\" for the time; the nearest is 'tick'"},
    {"no time", "tick,v\n1,1\n", motor, "name it with --time COLUMN: tick, v"},
    {"a column in two tables",
     "t,v\n1,1\n",
     motor,
     "is in a.csv and in b.csv; name its table too: b.csv:v",
     {{"b.csv", "t,v\n1,1\n"}}},
    {"a column that occurs twice", "t,v,v\n1,1,2\n", motor, "column \"v\" occurs twice"},
    {"a word for a number", "t,v\n1,1\n2,fast\n", motor,
     "a.csv:3: column \"v\": \"fast\" is not a number"},
    {"a word for a time", "t,v\n1,1\nlater,2\n", motor, "\"later\" is not a time"},
    {"a row of other length", "t,v\n1,1\n2,1,5\n", motor,
     "a.csv:3: 3 fields where the header has 2"},
    {"rows of hours", "t,v\n0,1\n10,1\n20,1\n", motor,
     "its rows are 10 s apart; state the unit of the time"},
    {"a unit that is not supported", "t,v (mph)\n0,1\n", motor, "\"mph\" is not known"},
    {"a unit of something else", "t,v\n0,1\n", "--column motor=v,unit=m/s2",
     "does not fit this role"},
    {"turns without a radius", "t,v\n0,1\n", "--column motor=v,unit=rpm", "radius"},
    {"an unknown key", "t,v\n0,1\n", "--column motor=v,scal=2", "did you mean \"scale\""},
    {"a key of frames", "t,v\n0,1\n", "--column motor=v,bus=can0", "unknown key"},
    {"an unknown role", "t,v\n0,1\n", "--column moter=v", "did you mean \"motor\""},
    {"no role", "t,v\n0,1\n", "--column v", "ROLE=COLUMN"},
    {"no sensor", "t,a\n0,1\n", pose, "no column is mapped to a role"},
    {"no speed", rows_of("t,w", 0), "--column yaw_rate=w", "no speed is mapped"},
    {"speeds beyond any car", "t,v\n0,100\n0.1,300\n", motor,
     "2 of 2 values are beyond -83 to 83 m/s, up to 300"},
    {"a column without a value", "t,v,w\n0,1,\n0.1,1,nan\n", motor + "--column yaw_rate=w",
     "the column has no value"},
    {"other clocks",
     rows_of("t,v", 0),
     motor + "--column yaw_rate=w",
     "these have no time in common",
     {{"b.csv", rows_of("t,w", 1.7e9)}}},
    {"a camera without sigma", "t,v,a\n0,1,1\n", motor + pose, "camera.sigma_x is missing"},
    {"a camera without a heading", "t,v,a\n0,1,1\n",
     motor + "--column camera.x=a --column camera.y=a", "camera.yaw is missing"},
    {"half a quaternion", "t,v,a\n0,1,1\n",
     motor + "--column truth.x=a --column truth.y=a --column truth.qw=a", "truth.qz is missing"},
    {"poses of two tables",
     "t,v,a\n0,1,1\n",
     motor + "--column truth.x=a --column truth.y=b --column truth.yaw=a",
     "in another table",
     {{"b.csv", "t,b\n0,1\n"}}},
    {"an unknown field", "t,v,a\n0,1,1\n", motor + "--column camera.z=a", "unknown field"},
    {"UTF-16", std::string("\xFF\xFEt\0,\0v\0", 8), motor, "iconv -f UTF-16"},
    {"nothing", "", motor, "a.csv: is empty"},
    {"a header alone", "t,v\n", motor, "a.csv: has no rows"},
    {"numbers alone", "1,2\n2,3\n", motor,
     "a.csv:1: holds numbers where the names of the columns should be"},
    {"a candump log", "(1.000000) can0 1A3#00\n", motor, "is a candump log"},
    {"a VBOX file", "[column names]\ntime v\n[data]\n1 2\n", motor, ".vbo"},
    {"times of day", "time,v\n101558.5,1\n101559.5,1\n101600.5,1\n101601.5,1\n", motor,
     "--time 'time,unit=hhmmss'"},
    {"a unit in Latin-1", "t,v (\xB0/s)\n0,1\n", motor, "needs `radius`"},
    {"no table", {}, motor, "no table"},
    {"an empty name", "t,v,\n0,1,\n", "--column motor=", "names no column"},
};

TEST(Import, RefusesAndLeavesNothingBehind) {
  for (const Case& one : cases) {
    SCOPED_TRACE(one.what);
    const Scratch scratch;
    std::vector<TextFile> files = one.others;
    if (one.table) files.insert(files.begin(), {"a.csv", *one.table});
    EXPECT_THAT(import(scratch, files, one.options + a_car), Ends(2, HasSubstr(one.message)));
    std::size_t entries = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(scratch.path("")))
      ++entries;
    EXPECT_EQ(entries, files.size());
  }
}

TEST(Import, AsksForTheCar) {
  const Scratch scratch;
  EXPECT_THAT(import(scratch, {{"a.csv", "t,v\n0,1\n"}}, motor), Ends(2, HasSubstr("--wheelbase")));
}

TEST(Import, LeavesOutAndCountsWhatDoesNotFit) {
  const Scratch scratch;
  std::string table = "t,v,w\n";
  for (int i = 0; i < 50; ++i)
    table += std::to_string(0.01 * i) + (i == 7 ? ",900" : ",1") + ",0.000" +
             std::to_string(i % 3) + "\n";
  EXPECT_THAT(import(scratch, {{"a.csv", table + ",1,1\n"}}, motor + "--column yaw_rate=w" + a_car),
              Ends(0, AllOf(HasSubstr("1 of 50 values are beyond -83 to 83 m/s, up to 900"),
                            HasSubstr("1 row without a time left out"))));
}

}  // namespace
}  // namespace odomd::tools::import_refusals_test
