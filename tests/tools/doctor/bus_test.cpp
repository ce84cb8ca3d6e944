// Mistakes on a bus: its interface and its frames.
#include "tools/doctor/bus.hpp"

#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/fault/small_car.hpp"

namespace odomd::tools::doctor::bus_test {
namespace {

using diagnostics::Diagnostics;
using diagnostics::Named;

Link sound_link() {
  Link link;
  link.controller = can::Controller{};
  link.controller->health = can::ControllerHealth::error_active;
  link.controller->restart_ms = 100;
  link.controller->bit_timing = can::BitTiming{.bitrate = 500'000};
  return link;
}

Diagnostics of(const Link& link, can::FrameProtocol needed = can::FrameProtocol::classic) {
  return examine_link("can0", link, needed);
}

TEST(Link, ThatIsSoundOrVirtualGivesNothing) {
  EXPECT_THAT(of(sound_link()), IsEmpty());
  EXPECT_THAT(of(Link{}), IsEmpty());
  Link fd = sound_link();
  fd.carries_fd = true;
  EXPECT_THAT(of(fd, can::FrameProtocol::fd), IsEmpty());
}

TEST(Link, ThatIsMissingOrOfAnotherKindIsNamed) {
  EXPECT_THAT(examine_link("can7", std::nullopt), ElementsAre(Named("interface_missing", "can7")));
  Link other;
  other.is_can = false;
  EXPECT_THAT(of(other), ElementsAre(Named("interface_not_can", "can0")));
  EXPECT_FALSE(read_link("no-such-bus"));
  ASSERT_TRUE(read_link("lo"));
  EXPECT_FALSE(read_link("lo")->is_can);
}

TEST(Link, ThatIsDownGetsTheCommandThatSetsItUp) {
  Link link = sound_link();
  link.is_up = false;
  link.controller->health = can::ControllerHealth::stopped;
  EXPECT_THAT(of(link), ElementsAre(Named("interface_down", "", "sudo ip link set can0 up")));
}

TEST(Link, WithoutABitRateIsNotAlsoCalledDown) {
  Link link = sound_link();
  link.is_up = false;
  link.controller->bit_timing.reset();
  link.controller->restart_ms = 0;
  EXPECT_THAT(of(link), ElementsAre(Named("no_bit_rate", "",
                                          HasSubstr("ip link set can0 type can bitrate"))));
}

TEST(Link, ThatStaysOffTheBusOrSeesErrorsIsNamed) {
  Link link = sound_link();
  link.controller->restart_ms = 0;
  EXPECT_THAT(of(link), ElementsAre(Named("no_restart", "",
                                          HasSubstr("ip link set can0 type can restart-ms 100"))));

  link = sound_link();
  link.controller->errors = can::ErrorCounters{.transmit = 3, .receive = 131};
  for (const auto health :
       {can::ControllerHealth::error_warning, can::ControllerHealth::error_passive}) {
    link.controller->health = health;
    EXPECT_THAT(of(link),
                ElementsAre(AllOf(Named("bus_errors", "131", HasSubstr("bit rate of can0")),
                                  Named("bus_errors", std::string{can::name_of(health)}))));
  }
  link.controller->health = can::ControllerHealth::bus_off;
  EXPECT_THAT(of(link), ElementsAre(Named("bus_off", "", HasSubstr("set can0 down and up"))));
}

TEST(Link, WithoutCanFdIsNamedWhereItIsNeeded) {
  EXPECT_THAT(of(sound_link(), can::FrameProtocol::fd), ElementsAre(Named("no_can_fd", "can0")));
}

// The small car of the fault tests: four messages, every 10 ms, over three seconds.
Drive small_drive() {
  Drive drive;
  drive.name = "can0";
  drive.config = fault::small_car();
  drive.databases = {sim::bus_database()};
  drive.buses = {"can0"};
  drive.frames = fault::healthy_frames();
  for (can::Message& message : drive.databases[0].messages) message.cycle_time_ns = fault::cycle_ns;
  return drive;
}

const can::Message& message_of(const Drive& drive, std::string_view name) {
  return *can::find_message(drive.databases[0], name);
}

TEST(Traffic, OfASoundCarGivesNothing) {
  EXPECT_THAT(examine_traffic(small_drive()), IsEmpty());
}

TEST(Traffic, IsCountedByIdentifierMappedOrNot) {
  Drive drive = small_drive();
  can::Frame other = drive.frames.front();
  other.id = 0x700;
  drive.frames.push_back(other);
  const std::vector<Identifier> seen = identifiers_of(drive);
  ASSERT_EQ(seen.size(), 5U);
  EXPECT_EQ(seen[0].bus, "can0");
  EXPECT_EQ(seen[0].message, "WHEELS_FRONT");
  EXPECT_EQ(seen[0].frames, 300U);
  EXPECT_NEAR(seen[0].rate_hz, 100.0, 0.1);
  EXPECT_EQ(seen[4].id, 0x700U);
  EXPECT_EQ(seen[4].message, "");
  EXPECT_EQ(seen[4].rate_hz, 0.0);
  EXPECT_THAT(examine_traffic(drive), IsEmpty());
}

TEST(Traffic, WithTheOtherFormatOfAnIdentifierGivesTheNumberForTheDatabase) {
  Drive drive = small_drive();
  const std::uint32_t id = message_of(drive, "STEERING").id;
  for (can::Frame& frame : drive.frames)
    if (frame.id == id) frame.format = can::IdFormat::extended;
  EXPECT_THAT(examine_traffic(drive),
              ElementsAre(Named("other_id_format", "STEERING",
                                HasSubstr(std::to_string(0x8000'0000U + id)))));
}

TEST(Traffic, AtAnotherRateGivesTheLineForTheDatabase) {
  Drive drive = small_drive();
  for (can::Message& message : drive.databases[0].messages)
    if (message.name == "IMU") message.cycle_time_ns = 2 * fault::cycle_ns;
  EXPECT_THAT(
      examine_traffic(drive),
      ElementsAre(Named("other_rate", "100 times", HasSubstr("\"GenMsgCycleTime\" BO_ 418 10;"))));
}

TEST(Traffic, SlowerThanTheTimeoutNamesTheKey) {
  Drive drive = small_drive();
  for (can::Message& message : drive.databases[0].messages) message.cycle_time_ns = 0;
  EXPECT_THAT(examine_traffic(drive), IsEmpty());  // no timeout is known either
  for (daemon::SignalSettings& signal : drive.config.can.signals)
    signal.timeout_ns = fault::cycle_ns / 2;
  drive.config.can.signals[estimator::index_of(estimator::Source::steering)].timeout_ns = 0;
  const Diagnostics found = examine_traffic(drive);
  EXPECT_EQ(found.size(), 3U);
  EXPECT_THAT(found, Contains(Named("slower_than_timeout", "can.signals.yaw_rate")));
}

TEST(Traffic, TooShortOrFailingItsProtectionIsNamed) {
  Drive drive = small_drive();
  const std::uint32_t wheels = message_of(drive, "WHEELS_REAR").id;
  const std::uint32_t imu = message_of(drive, "IMU").id;
  for (can::Frame& frame : drive.frames) {
    if (frame.id == wheels) frame.length = 2;
    if (frame.id == imu) frame.data[frame.length - 1U] ^= 0x55U;
  }
  EXPECT_THAT(examine_traffic(drive),
              UnorderedElementsAre(Named("message_without_value", "WHEELS_REAR"),
                                   Named("message_without_value", "IMU")));
}

TEST(Acknowledgement, IsMissedByAListenerThatHearsNothingOrOneFrameAgainAndAgain) {
  const auto of = [](const Drive& drive, const Link& link) {
    return examine_acknowledgement("can0", link, drive);
  };
  Link listener = sound_link();
  listener.controller->modes = {"bus_error_reporting", "listen_only"};
  Drive drive = small_drive();
  EXPECT_THAT(of(drive, listener), IsEmpty());
  // The log's first frame repeated without a pause, mapped or not.
  can::Frame frame = drive.frames.front();
  drive.frames.clear();
  EXPECT_THAT(of(drive, listener), ElementsAre(Named("nobody_acknowledges", "no frame comes")));
  for (int i = 0; i < 3000; ++i) {
    frame.time_ns += 300'000;
    (i % 2 == 0 ? drive.frames : drive.unmapped).push_back(frame);
  }
  EXPECT_THAT(of(drive, listener),
              ElementsAre(Named("nobody_acknowledges", "3000 times",
                                HasSubstr("set can0 type can listen-only off"))));
  // A controller that may acknowledge, or a virtual one.
  EXPECT_THAT(of(drive, sound_link()), IsEmpty());
  EXPECT_THAT(of(drive, Link{}), IsEmpty());
  // A changing payload or identifier, or pauses in between, mean that frames are acknowledged; a
  // single frame shows nothing.
  for (void (*const change)(Drive&) : {+[](Drive& one) { one.frames.back().data[0] ^= 1U; },
                                       +[](Drive& one) { one.unmapped.back().id += 1; },
                                       +[](Drive& one) {
                                         for (auto* frames : {&one.frames, &one.unmapped})
                                           for (can::Frame& late : *frames) late.time_ns *= 60;
                                       },
                                       +[](Drive& one) {
                                         one.frames.resize(1);
                                         one.unmapped.clear();
                                       }}) {
    Drive other = drive;
    change(other);
    EXPECT_THAT(of(other, listener), IsEmpty());
  }
  // Frames of another bus do not count.
  drive.buses = {"can1", "can0"};
  EXPECT_THAT(of(drive, listener), ElementsAre(Named("nobody_acknowledges", "no frame comes")));
}

TEST(NeededProtocol, IsThatOfTheMappedMessages) {
  Drive drive = small_drive();
  EXPECT_EQ(needed_protocol(drive.config, drive.databases), can::FrameProtocol::classic);
  drive.databases[0].messages.back().protocol = can::FrameProtocol::fd;
  EXPECT_EQ(needed_protocol(drive.config, drive.databases), can::FrameProtocol::fd);
}

}  // namespace
}  // namespace odomd::tools::doctor::bus_test
