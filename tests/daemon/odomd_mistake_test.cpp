// Errors at start are reported in one line, with exit status 2, or 1 for errors of the machine.
#include <sys/stat.h>

#include <filesystem>

#include "daemon_process.hpp"

namespace odomd::testing::odomd_mistake_test {
namespace {

class OdomdMistake : public ::testing::Test {
 protected:
  std::string error_of(const std::vector<std::string>& arguments, int status = 2) {
    desk_.write("stderr", "");
    DaemonProcess odomd(desk_, arguments);
    EXPECT_EQ(odomd.wait(), status);
    auto errors = desk_.read("stderr");
    EXPECT_EQ(errors.find('\n'), errors.size() - 1) << errors;
    return errors;
  }

  Desk desk_;
};

TEST_F(OdomdMistake, InTheFiles) {
  const std::string car = desk_.read("car.toml"), source = "source = \"-\"\n";
  desk_.write("car.toml", "[vehicle]\nmas = 3\n" + car.substr(10));
  EXPECT_THAT(error_of({}), HasSubstr("car.toml:2: [vehicle] mas: unknown key; did you mean"));
  std::string without = car;
  desk_.write("car.toml", without.erase(car.find(source), source.size()));
  EXPECT_THAT(error_of({}), HasSubstr("no CAN source is named; give --can can0"));
  desk_.write("car.toml", car);
  desk_.write("car.dbc", "BO_ what is this\n");
  EXPECT_THAT(error_of({}), HasSubstr("car.dbc:1: "));
}

TEST_F(OdomdMistake, OnTheCommandLine) {
  std::pair<std::vector<std::string>, std::string> cases[]{
      {{"--can", "/nowhere/drive.log"}, "/nowhere/drive.log"},
      {{"--can", "-", "--can", "-"}, "--can: names \"-\" twice"},
      {{"--model", "particle"},
       "--model: \"particle\" is not a model of this version; the models are: kinematic"},
      {{"--initial", "1,2"}, "--initial: \"1,2\" is not a pose"},
      {{"--nonsense"}, "--nonsense"},
      {{"--shm", "odomd"}, "--shm: \"odomd\" must begin with a slash"},
      {{"--shm", "/."}, "/."},
      {{"--shm", desk_.file(std::string(300, 'a'))}, "aaa"},
      {{"--camera-socket", desk_.file(std::string(120, 'a'))}, "aaa"}};
  for (const auto& [arguments, says] : cases) EXPECT_THAT(error_of(arguments), HasSubstr(says));
  for (const std::string option : {"--shm", "--can", "--camera-socket", "--status-socket",
                                   "--runtime-directory", "--readers", "--initial", "--model"})
    EXPECT_THAT(error_of({option, ""}), HasSubstr(option + ": is empty; give a value"));
}

TEST_F(OdomdMistake, TwoFilesWithOnePathInAnySpelling) {
  const std::string camera = desk_.file("camera.sock"), status = desk_.file("status.sock");
  std::filesystem::create_directory_symlink(desk_.file("."), desk_.file("link"));
  for (const auto& [option, path] : std::vector<std::pair<std::string, std::string>>{
           {"--shm", camera},
           {"--shm", desk_.file("link/./camera.sock")},
           {"--shm", desk_.file("record.sock")},
           {"--camera-socket", status},
           {"--status-socket", desk_.file("nowhere/../camera.sock")},
           {"--status-socket", desk_.segment()},
           {"--status-socket", desk_.segment() + ".lock"},
           {"--camera-socket", desk_.file("car.toml")},
           {"--shm", desk_.file("link/car.dbc")}})
    EXPECT_THAT(error_of({option, path}), HasSubstr(" have one path, ")) << option << path;
  const std::string car = desk_.read("car.toml");
  for (const char* log : {"car.toml", "link/car.dbc", "camera.sock", "pose"}) {
    desk_.write("car.toml", car + "[log]\nfile = \"" + log + "\"\n");
    EXPECT_THAT(error_of({}), HasSubstr(" have one path, ")) << log;
  }
  desk_.write("car.toml", car);
  EXPECT_EQ(desk_.read("car.dbc").find("VERSION"), 0U);
}

TEST_F(OdomdMistake, APipeOrADeviceForAFile) {
  const std::string car = desk_.read("car.toml");
  ASSERT_EQ(::mkfifo(desk_.file("pipe").c_str(), 0600), 0);
  for (const auto& [file, kind] : std::vector<std::pair<std::string, std::string>>{
           {"pipe", "is a named pipe; name a file"}, {"/dev/zero", "is a device; name a file"}}) {
    desk_.write("car.toml", car + "[log]\nfile = \"" + file + "\"\n");
    EXPECT_THAT(error_of({}), AllOf(HasSubstr("[log] file "), HasSubstr(kind)));
    std::string other = car;
    desk_.write("car.toml", other.replace(other.find("car.dbc"), 7, file));
    EXPECT_THAT(error_of({}), HasSubstr(kind));
    std::filesystem::remove(desk_.file("car.toml"));
    std::filesystem::create_symlink(file, desk_.file("car.toml"));
    EXPECT_THAT(error_of({}), HasSubstr("car.toml: " + kind));
    std::filesystem::remove(desk_.file("car.toml"));
  }
}

}  // namespace
}  // namespace odomd::testing::odomd_mistake_test
