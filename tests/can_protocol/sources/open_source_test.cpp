// Which kind of source a name means, the errors of invalid names, and interfaces without a CAN
// controller.
#include "can_protocol/sources/open_source.hpp"

#include <sys/socket.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "base/file_descriptor.hpp"
#include "can_protocol/sources/controller.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::open_source_test {
namespace {

bool kernel_has_can() {
  return static_cast<bool>(FileDescriptor(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1)));
}

TEST(SourceKind, DependsOnTheNameAndOnExistingFiles) {
  const TemporaryFile file("drive", "");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(file.directory());
  for (const auto& [name, kind] : {std::pair{"-", SourceKind::standard_input},
                                   {"can0", SourceKind::interface},
                                   {"vcan-front.1", SourceKind::interface},
                                   {"drive2", SourceKind::interface},
                                   {"drive", SourceKind::log},
                                   {"drive.log", SourceKind::log},
                                   {"./can0", SourceKind::log},
                                   {"/nonexistent/drive", SourceKind::log}})
    EXPECT_EQ(source_kind(name), kind) << name;
  std::filesystem::current_path(before);
}

TEST(SourceKind, RefusesImpossibleNames) {
  for (const char* const name : {"", ".", "..", "can 0", "can:0", "an-interface-16c", "can0\n"})
    EXPECT_THROW((void)source_kind(name), std::invalid_argument) << name;
}

class OpenSource : public testing::Test {
 protected:
  BusNames buses;
  LogClock clock{0, 5'000'000};
};

TEST_F(OpenSource, OpensALog) {
  const TemporaryFile file("drive.log", "(1.000000) can0 100#\n");
  const auto source = open_source(file.path(), buses, clock, {});
  EXPECT_EQ(source->name(), file.path());
  EXPECT_THROW((void)open_source("nonexistent.log", buses, clock, {}), LogError);
}

TEST_F(OpenSource, RefusesOneBusTooMany) {
  for (char bus = '0'; bus < '8'; ++bus) buses.index_of(std::string("can") + bus);
  EXPECT_THROW((void)open_source("can8", buses, clock, {}), std::invalid_argument);
}

TEST_F(OpenSource, WaitsForAnInterfaceOrReportsAKernelWithoutCan) {
  if (kernel_has_can()) {
    const auto source = open_source("odomd-test-none", buses, clock, {});
    EXPECT_EQ(source->link(), LinkState::gone);
    source->maintain();
    EXPECT_EQ(source->link(), LinkState::gone);
    return;
  }
  EXPECT_THAT(message_of([&] { (void)open_source("can0", buses, clock, {}); }),
              HasSubstr("can0: this kernel has no CAN sockets"));
}

// Real controllers are tested in the lab.
TEST(Controller, IsEmptyWithoutOutputIfTheInterfaceIsMissingOrNotCan) {
  testing::internal::CaptureStderr();
  for (const char* const name :
       {"no-such-bus", "lo", "", "an interface's name is never as long as this one"})
    EXPECT_FALSE(read_controller(name)) << name;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Controller, HealthHasANameForEveryValue) {
  EXPECT_EQ(name_of(ControllerHealth::error_active), "error_active");
  EXPECT_EQ(name_of(ControllerHealth::bus_off), "bus_off");
  EXPECT_EQ(name_of(ControllerHealth::sleeping), "sleeping");
}

}  // namespace
}  // namespace odomd::can::open_source_test
