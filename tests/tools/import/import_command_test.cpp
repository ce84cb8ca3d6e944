// odom import: tables as written by other tools. Whatever is not a table of a drive is refused in
// one line, and no file is left.
#include <optional>

#include "tests/tools/import/importing.hpp"

namespace odomd::tools::import_command_test {
namespace {

using nlohmann::json;

/// Expected samples of the first role: number, smallest and largest value, and the time of the
/// first frame.
struct Case {
  std::string what, table, options;
  std::size_t samples;
  double least, most, first;
  std::vector<TextFile> others{};
};

const std::vector<Case> cases{
    {"a ROS 2 topic with nested names and two columns of the stamp",
     "header.stamp.sec,header.stamp.nanosec,header.frame_id,twist.twist.linear.x\n"
     "1700000000,5,\"a, \"\"b\"\"\",1.5\n1700000000,50000005,odom,2.5\n",
     "--column motor=twist.twist.linear.x", 2, 1.5, 2.5, 1700000000.000000005},
    {"a ROS 1 topic in nanoseconds: the sensor's stamp goes before the recorder's",
     "%time,field.header.seq,field.header.stamp,field.angular_velocity.z,field.v\n"
     "1700000000200000000,1,1700000000100000000,0.25,1\n"
     "1700000000300000000,2,1700000000200000000,-0.5,1\n",
     "--column yaw_rate=field.angular_velocity.z --column motor=field.v", 2, -0.5, 0.25,
     1700000000.1},
    {"PlotJuggler's export, with empty cells",
     "__time,/imu/gyro/z,/odom/v\n1700000000.1,0.5,\n1700000000.15,,1\n"
     "1700000000.2,1.5,\n1700000000.25,nan,2\n",
     "--column yaw_rate=/imu/gyro/z --column motor=/odom/v", 2, 0.5, 1.5, 1700000000.1},
    {"semicolons, decimal commas, a byte order mark and CRLF",
     "\xEF\xBB\xBFTime (s);Speed (km/h)\r\n10,5;36,0\r\n10,6;72\r\n10,7;-\r\n",
     "--column 'wheel_rear=Speed (km/h)'", 2, 10.0, 20.0, 10.5},
    {"tabs, lines before the header, a row of units below",
     "Format\tMoTeC CSV File\n\nVenue\tTrack, north\nTime\tYaw\tVel\ns\tdeg/s\tkm/h\n\n"
     "0.0\t90\t3.6\n0.1\t-90\t3.6\n",
     "--column yaw_rate=Yaw --column motor=Vel", 2, -1.5707963, 1.5707963, 0.0},
    {"the header as a comment, and comments between", "# t, v\n0.0, 1.5\n# gap\n0.1, 2.5\n",
     "--column motor=v", 2, 1.5, 2.5, 0.0},
    {"milliseconds by the name", "time_ms,v\n5000,1\n5100,2\n", "--column motor=v", 2, 1, 2, 5.0},
    {"microseconds as stated", "tick,v\n5000000,1\n5100000,2\n",
     "--column motor=v --time tick,unit=us", 2, 1, 2, 5.0},
    {"milliseconds by their size", "timestamp,v\n1700000000125,1\n1700000000225,2\n",
     "--column motor=v", 2, 1, 2, 1700000000.125},
    {"seconds in the exponent form of a spreadsheet",
     "timestamp,v\n1.7000000001E+09,1\n1.7000000002E+09,2\n", "--column motor=v", 2, 1, 2,
     1700000000.1},
    {"the time of day of a VBOX", "sats,time,velocity\n9,003523.40,36\n9,003600.50,72\n",
     "--column motor=velocity,unit=km/h --time time,unit=hhmmss", 2, 10, 20, 2123.4},
    {"hhmmss in the row of units, rows with a comma more, names with the unit",
     "File created @ 10:21:07\n\nsats,time,lat,velocity (km/h)\n-,hhmmss,min,km/h\n"
     "9,3523.4,3119.1,36,\n9,3523.5,3119.1,72\n",
     "--column motor=velocity", 2, 10, 20, 2123.4},
    {"the nanoseconds of a header that is a comment",
     "#timestamp [ns],w_z [rad s^-1],v\n1403636579758555392,0.1,1\n"
     "1403636579763555584,0.2,1\n",
     "--column yaw_rate=w_z --column motor=v", 2, 0.1, 0.2, 1403636579.758555},
    {"times with a date", "t,v\n2026-01-16 01:22:28.125,1\n2026-01-16T01:22:29.5Z,2\n",
     "--column motor=v", 2, 1, 2, 1768526548.125},
    {"negative times are shifted by whole seconds", "t,v\n-1.5,1\n-1.4,2\n", "--column motor=v", 2,
     1, 2, 0.5},
    {"turns of the motor", "t,erpm\n0,6000\n0.1,3000\n",
     "--column motor=erpm,unit=rpm,radius=0.05,ratio=10,scale=-1", 2, -3.1415927, -1.5707963, 0.0},
    {"a steering command with a trim", "t,v,cmd\n0,1,-1\n0.1,1,1\n",
     "--column steering=cmd,unit=1,scale=0.35,offset=0.01 --column motor=v", 2, -0.34, 0.36, 0.0},
    {"electrical turns of the motor", "t,erpm\n0,6000\n0.1,3000\n",
     "--column motor=erpm,unit=erpm,radius=0.05,ratio=5,pole_pairs=2", 2, 1.5707963, 3.1415927,
     0.0},
    {"rad/s of a wheel, which the row below states", "t,w\ns,rad/s\n0,20\n0.1,30\n",
     "--column wheel_rear=w,unit=rad/s,radius=0.05", 2, 1.0, 1.5, 0.0},
    {"g", "t,ay,v\n0,1,1\n0.1,-1,1\n", "--column accel_y=ay,unit=g --column motor=v", 2, -9.80665,
     9.80665, 0.0},
    {"a last line that is cut off", "t,x,v\n0,7,1\n0.1,7,2\n0.2,", "--column motor=v", 2, 1, 2,
     0.0},
    {"a column with a comma in its name", "t,\"v, rear\"\n0,1\n0.1,2\n",
     "--column 'motor=\"v, rear\",unit=m/s'", 2, 1, 2, 0.0},
    {"one name in two tables",
     rows_of("t,x", 0),
     "--column yaw_rate=a:x --column motor=b.csv:x",
     5,
     1.0,
     1.4,
     0.0,
     {{"b.csv", rows_of("t,x", 0.05)}}},
};

TEST(Import, ReadsTheTablesOfOtherTools) {
  for (const Case& one : cases) {
    SCOPED_TRACE(one.what);
    const Scratch scratch;
    std::vector<TextFile> files{{"a.csv", one.table}};
    files.insert(files.end(), one.others.begin(), one.others.end());
    const Outcome outcome = import(scratch, files, one.options + a_car + "--json");
    if (outcome.status != 0) {
      ADD_FAILURE() << outcome.err;
      continue;
    }
    const json result = json::parse(outcome.out), role = result["roles"][0];
    EXPECT_EQ(role["samples"], one.samples);
    EXPECT_NEAR(role["least"].get<double>(), one.least, 1e-6);
    EXPECT_NEAR(role["most"].get<double>(), one.most, 1e-6);
    EXPECT_NEAR(result["first"].get<double>(), one.first, 1e-6);
    scratch.must_run("odomd --check --config out/car.toml");
  }
}

// A value must not be sent again because another signal's value has arrived.
TEST(Import, SendsEachValueOnceAtItsTime) {
  const Scratch scratch;
  const Outcome outcome =
      import(scratch,
             {{"a.csv", "t,r,ax,ay,v\n1,0.1,1,,1\n1.1,0.2,,,\n1.2,0.3,2,5,1\n"},
              {"b.csv", "t,s\n1.05,0.1\n1.15,0.2\n"}},
             "--column yaw_rate=r --column accel_x=ax --column accel_y=ay --column wheel_rear=v "
             "--column motor=b:s" +
                 std::string(a_car));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(scratch.text("out/car.toml"),
              AllOf(HasSubstr("signal = \"AccX\""), HasSubstr("bus = \"can2\"")));
  const std::string log = scratch.text("out/drive.log");
  EXPECT_EQ(std::ranges::count(log, '\n'), 3 + 2 + 1 + 2 + 2);
  EXPECT_THAT(log, AllOf(HasSubstr("1.050000000) can1 1A1#"), HasSubstr("1.100000000) can0 1A2#"),
                         Not(HasSubstr("1.100000000) can1 1A2#"))));
}

TEST(Import, ConvertsQuaternionsDegreesAndMillimetresToPoses) {
  const Scratch scratch;
  const Outcome outcome = import(
      scratch,
      {{"odom.csv", rows_of("t,v", 100)},
       {"pose.csv",
        "t,rx,px,py,qx,qy,qz,qw\n100.1,100.15,1000,2000,0,0,0.70710678,0.70710678\n"
        "100.2,,1000,2000,0,0,0,1\n100.3,100.31,0,0,0,0,0,0\n"},
       {"gps.csv", "t,east,north,head,v\n100,0,1,90,3.6\n100.2,0.5,1,0,7.2\n"}},
      "--column motor=odom:v --column camera.x=px,scale=0.001 --column camera.y=py,unit=mm "
      "--column camera.qx=qx --column camera.qy=qy --column camera.qz=qz --column camera.qw=qw "
      "--column camera.sigma_x=0.01 --column camera.sigma_yaw=1,unit=deg "
      "--column camera.arrival=rx --column camera.latency=0.01 "
      "--column truth.x=east --column truth.y=north --column truth.vx=gps:v,unit=km/h "
      "--column truth.vy=0 --column truth.yaw_rate=0 "
      "--column truth.yaw=head,unit=deg,scale=-1,offset=1.57079632679" +
          std::string(a_car));
  ASSERT_THAT(outcome, Ends(0, HasSubstr("2 of 3 rows lack a value")));
  const std::string camera = scratch.text("out/camera.csv");
  EXPECT_THAT(camera, HasSubstr("\n100.160000000,100.100000000,1,2,1.570796"));
  EXPECT_THAT(camera, HasSubstr(",0.01,0.01,0.0174532"));
  const std::string truth = scratch.text("out/truth.csv");
  EXPECT_THAT(truth, HasSubstr("t,x,y,yaw,vx,vy,yaw_rate\n100.000000000,0,1,"));
  EXPECT_THAT(truth, HasSubstr("\n100.200000000,0.5,1,1.57079632679,2,0,0\n"));
}

TEST(Import, KeepsTheCarOfAConfigurationAndReplacesADriveOnlyWithForce) {
  const Scratch scratch;
  simulate(scratch, "--config-only", "sim");
  const std::vector<TextFile> files{{"a.csv", rows_of("t,v,x,yaw", 0, ",1,2")}};
  const std::string columns = "--config sim/car.toml --column wheel_rear_left=v,timeout=0.7 ";
  ASSERT_EQ(import(scratch, files,
                   columns + "--column truth.x=x --column truth.y=x --column truth.yaw=yaw")
                .status,
            0);
  EXPECT_THAT(scratch.text("out/car.toml"),
              AllOf(HasSubstr("yaw_inertia = 0.028"), HasSubstr("lever_arm"), HasSubstr("[imu]"),
                    HasSubstr("sigma = 0.00649, timeout = 0.7, latency = 0.005"),
                    Not(HasSubstr("SteeringAngle"))));
  ASSERT_TRUE(std::filesystem::exists(scratch.path("out/truth.csv")));
  scratch.write("out/notes.txt", "mine");
  const std::string log = scratch.text("out/drive.log");
  EXPECT_THAT(import(scratch, files, columns), Ends(2, HasSubstr("--force")));
  EXPECT_EQ(import(scratch, files, "--force --column motor=w").status, 2);
  EXPECT_EQ(scratch.text("out/drive.log"), log);
  EXPECT_EQ(import(scratch, files, columns + "--force").status, 0);
  EXPECT_FALSE(std::filesystem::exists(scratch.path("out/truth.csv")));
  EXPECT_EQ(scratch.text("out/notes.txt"), "mine");
}

struct Refusal {
  std::string what;
  std::optional<std::string> table;  ///< a.csv
  std::string options, message;
  std::vector<TextFile> others{};
};

const std::string motor = "--column motor=v ";
const std::string pose = "--column camera.x=a --column camera.y=a --column camera.yaw=a ";

const std::vector<Refusal> refusals{
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

TEST(Import, RefusesUnusableTablesAndLeavesNoFile) {
  for (const Refusal& one : refusals) {
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

TEST(Import, LeavesOutAndCountsUnusableValues) {
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
}  // namespace odomd::tools::import_command_test
