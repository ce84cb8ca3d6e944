// odom dbc: its output, and its errors for unusable files.
#include "tests/tools/scratch.hpp"

namespace odomd::tools::dbc_test {
namespace {

using ::testing::MatchesRegex;

constexpr const char* car = R"(BO_ 288 Imu: 4 ECU
 SG_ Yaw : 0|16@1- (0.5,0) [-16|16] "°/s" X
 SG_ Acc : 16|16@1- (0.01,-1) [0|0] "m/s2" X
BO_ 2147484000 Paged: 3 ECU
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" X
 SG_ One m1 : 8|8@1+ (1,0) [0|0] "" X
 SG_ Two m2 : 8|16@1+ (1,0) [0|0] "" X
CM_ BO_ 288 "Inertial
sensor";
VAL_ 2147484000 Page 1 "first" 2 "second" ;
BA_ "GenMsgCycleTime" BO_ 288 10;
)";

constexpr const char* drive =
    "(1760000000.069964) can0 120#0400A0FF\n"
    "(1760000000.070000) can0 7FF#00\n"
    "(1760000000.080001) can1 00000160#010A00\n"
    "(1760000000.080001234) can1 00000160#020A01\n"
    "(1760000000.090000) can0 120#FEFF\n"
    "(1760000000.100000) can0 120#R4\n";

class OdomDbc : public testing::Test {
 protected:
  OdomDbc() {
    scratch_.write("car.dbc", car);
    scratch_.write("drive.log", drive);
  }
  Scratch scratch_;
};

TEST_F(OdomDbc, DecodesOneJsonObjectAFrame) {
  const Outcome outcome = scratch_.run("odom dbc decode --dbc car.dbc --json drive.log");
  EXPECT_THAT(outcome, Ends(0, ""));
  EXPECT_EQ(outcome.out,
            R"({"t":1760000000.069964,"bus":"can0","id":288,"message":"Imu",)"
            R"("signals":{"Yaw":2.0,"Acc":-1.96}})"
            "\n"
            R"({"t":1760000000.080001,"bus":"can1","id":352,"extended":true,"message":"Paged",)"
            R"("signals":{"Page":1.0,"One":10.0}})"
            "\n"
            R"({"t":1760000000.080001234,"bus":"can1","id":352,"extended":true,"message":"Paged",)"
            R"("signals":{"Page":2.0,"Two":266.0}})"
            "\n"
            R"({"t":1760000000.090000,"bus":"can0","id":288,"message":"Imu",)"
            R"("signals":{"Yaw":-1.0}})"
            "\n");
}

TEST_F(OdomDbc, DecodesStandardInputForPeople) {
  EXPECT_THAT(scratch_.must_run("odom dbc decode --dbc car.dbc - <drive.log"),
              StartsWith("(1760000000.069964) can0 120 Imu  Yaw 2 °/s  Acc -1.96 m/s2\n"
                         "(1760000000.080001) can1 00000160 Paged  Page 1 (first)  One 10\n"));
}

TEST_F(OdomDbc, WritesNumbersAsPeopleDo) {
  scratch_.write("fine.dbc",
                 "BO_ 288 Imu: 4 X\n SG_ Acc : 0|16@1- (0.0005,0) [0|0] \"m/s2\" X\n"
                 " SG_ Level : 16|16@1+ (0.1,-100) [0|0] \"m\" X\nVAL_ 288 Level 1001 \"low\" ;\n");
  scratch_.write("fine.log", "(1.000000) can0 120#15FFE903\n");
  const std::string command = "odom dbc decode --dbc fine.dbc fine.log";
  EXPECT_EQ(scratch_.must_run(command),
            "(1.000000) can0 120 Imu  Acc -0.1175 m/s2  Level 0.1 m (low)\n");
  EXPECT_THAT(scratch_.must_run(command + " --json"),
              HasSubstr(R"("signals":{"Acc":-0.1175,"Level":0.1}})"));
}

TEST_F(OdomDbc, TakesTheFirstOfSeveralDatabases) {
  scratch_.write("other.dbc",
                 "BO_ 288 Shadowed: 4 X\nBO_ 2047 Diagnosis: 1 X\n"
                 " SG_ Code : 0|8@1+ (1,0) [0|0] \"\" X\n");
  EXPECT_THAT(scratch_.must_run("odom dbc decode --dbc car.dbc --json --dbc other.dbc drive.log"),
              AllOf(HasSubstr(R"("message":"Imu")"),
                    HasSubstr(R"("message":"Diagnosis","signals":{"Code":0.0}})"),
                    Not(HasSubstr("Shadowed"))));
}

TEST_F(OdomDbc, ShowsADatabase) {
  EXPECT_THAT(scratch_.must_run("odom dbc show car.dbc"),
              AllOf(HasSubstr("2 messages, 5 signals\n"),
                    HasSubstr("120 Imu  id 288, 4 bytes, every 10 ms, from ECU\n"
                              "  Inertial sensor\n"),
                    HasSubstr("00000160 Paged  id 352 extended, 3 bytes, from ECU\n"),
                    HasSubstr("m2 of Page")));
  scratch_.write("long.dbc", std::string(car) +
                                 "BA_ \"SystemMessageLongSymbol\" BO_ 288 \"Inertial\";\n"
                                 "BA_ \"SystemSignalLongSymbol\" SG_ 288 Yaw \"YawRate\";\n");
  EXPECT_THAT(scratch_.must_run("odom dbc show long.dbc"),
              AllOf(HasSubstr("120 Inertial (Imu)  id 288"), HasSubstr("YawRate (Yaw)")));
}

TEST_F(OdomDbc, SaysWhichFileItCannotUseAndWhy) {
  scratch_.write("cut.dbc", std::string_view(car).substr(0, std::string_view(car).size() / 2));
  scratch_.write("unusual.dbc", std::string(car) + "CM_ BO_ 77 \"no such\";\n");
  scratch_.write("wide.dbc", "BO_ 536870912 Wide: 8 X\n");
  scratch_.write("bad.log", std::string(drive) + "(1) can0 1#\n");
  expect_answers(scratch_, 2, "odom dbc", R"(
show cut.dbc -> cut.dbc:6: expected
show drive.log -> drive.log:1: expected a statement
show /nonexistent.dbc -> /nonexistent.dbc: cannot be read
show wide.dbc -> wide.dbc:1: no frame has the identifier 536870912
decode --dbc cut.dbc drive.log -> cut.dbc:6:
decode /nonexistent.log --dbc car.dbc -> /nonexistent.log
decode car.dbc --dbc car.dbc -> car.dbc:1:
decode drive.log -> --dbc
)");
  // The frames before the bad line are still printed.
  EXPECT_THAT(scratch_.run("odom dbc decode --strict --dbc unusual.dbc bad.log"),
              Ends(2, MatchesRegex("odom dbc decode: [^\n]*bad.log:7: expected [^\n]*\n")));
}

}  // namespace
}  // namespace odomd::tools::dbc_test
