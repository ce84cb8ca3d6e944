// The places where clients look when no name is given.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "shm_api/libodom/service.h"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_service_path {
namespace {

class ServicePath : public ::testing::Test {
 protected:
  void make(const std::string& name) const {
    std::filesystem::create_directories(std::filesystem::path(directory.file(name)).parent_path());
    std::ofstream(directory.file(name)) << "here";
  }

  /// What is found, below the directory.
  [[nodiscard]] std::string found(const std::string& leaf) const {
    char* path = nullptr;
    EXPECT_EQ(odomi_service_path(directory.file("run").c_str(), leaf.c_str(), &path), ODOM_OK);
    const std::string result(path);
    std::free(path);
    const std::string above = directory.file("");
    return result.starts_with(above) ? result.substr(above.size()) : result;
  }

  TemporaryDirectory directory;
};

TEST_F(ServicePath, WithoutAServiceItIsTheDirectoryItself) {
  EXPECT_EQ(found("pose"), "run/pose");
  make("run/other");
  EXPECT_EQ(found("pose"), "run/pose");
}

TEST_F(ServicePath, TheFirstInstanceByNameThatHasIt) {
  make("run/can2/pose");
  make("run/can1/pose");
  make("run/can3/pose");
  make("run/can0/status.sock");
  make("run/.hidden/pose");
  EXPECT_EQ(found("pose"), "run/can1/pose");
  EXPECT_EQ(found("status.sock"), "run/can0/status.sock");
}

TEST_F(ServicePath, AnInstanceBeatsTheDirectoryItself) {
  make("run/pose");
  EXPECT_EQ(found("pose"), "run/pose");
  make("run/can0/pose");
  EXPECT_EQ(found("pose"), "run/can0/pose");
}

TEST_F(ServicePath, NamesOfAnyLengthDoNoHarm) {
  const std::string longest(255, 'x');
  make("run/" + longest + "/pose");
  EXPECT_EQ(found("pose"), "run/" + longest + "/pose");
  EXPECT_EQ(found(std::string(300, 'y')), "run/" + std::string(300, 'y'));
}

}  // namespace
}  // namespace odomd::shm::testing::test_service_path
