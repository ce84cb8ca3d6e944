// Which kind of source a name means, and the errors of invalid names.
#include "can_protocol/sources/open_source.hpp"

#include <sys/socket.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "base/file_descriptor.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::open_source_test {
namespace {

constexpr std::int64_t period = 5'000'000;

bool kernel_has_can() {
  return static_cast<bool>(FileDescriptor(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1)));
}

TEST(SourceKind, GoesByTheName) {
  EXPECT_EQ(source_kind("-"), SourceKind::standard_input);
  EXPECT_EQ(source_kind("can0"), SourceKind::interface);
  EXPECT_EQ(source_kind("vcan-front.1"), SourceKind::interface);
  EXPECT_EQ(source_kind("drive.log"), SourceKind::log);
  EXPECT_EQ(source_kind("./can0"), SourceKind::log);
  EXPECT_EQ(source_kind("/nonexistent/drive"), SourceKind::log);
}

TEST(SourceKind, TakesTheNameOfAFileForALog) {
  const TemporaryFile file("drive", "");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(file.directory());
  EXPECT_EQ(source_kind("drive"), SourceKind::log);
  EXPECT_EQ(source_kind("drive2"), SourceKind::interface);
  std::filesystem::current_path(before);
}

TEST(SourceKind, RefusesWhatCanBeNeither) {
  for (const char* const name : {"", ".", "..", "can 0", "can:0", "an-interface-16c", "can0\n"})
    EXPECT_THROW((void)source_kind(name), std::invalid_argument) << name;
}

TEST(OpenSource, OpensALog) {
  const TemporaryFile file("drive.log", "(1.000000) can0 100#\n");
  BusNames buses;
  LogClock clock(0, period);
  const auto source = open_source(file.path(), buses, clock, {});
  EXPECT_EQ(source->name(), file.path());
  EXPECT_THROW((void)open_source("nonexistent.log", buses, clock, {}), LogError);
}

TEST(OpenSource, RefusesOneBusTooMany) {
  BusNames buses;
  for (char bus = '0'; bus < '8'; ++bus) buses.index_of(std::string("can") + bus);
  LogClock clock(0, period);
  EXPECT_THROW((void)open_source("can8", buses, clock, {}), std::invalid_argument);
}

TEST(OpenSource, WaitsForAnInterfaceOrSaysThatTheKernelHasNoCan) {
  BusNames buses;
  LogClock clock(0, period);
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

}  // namespace
}  // namespace odomd::can::open_source_test
