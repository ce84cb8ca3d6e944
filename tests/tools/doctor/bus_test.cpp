// Mistakes on a bus: its interface and its frames.
#include "tools/doctor/doctor.hpp"

#include "tests/diagnostics.hpp"
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
  link.controller->bit_timing.emplace().bitrate = 500'000;
  return link;
}

using Found = ::testing::Matcher<const Diagnostics&>;

TEST(Link, GetsAFindingForEachMistake) {
  using enum can::ControllerHealth;
  using Change = void (*)(Link&);
  constexpr auto classic = can::FrameProtocol::classic, fd = can::FrameProtocol::fd;
  const auto set_up = HasSubstr("ip link set can0 type can bitrate");
  struct Case {
    Change change;
    Found found;
    can::FrameProtocol needed = classic;
  };
  const Case cases[]{
      {[](Link&) {}, IsEmpty()},
      {[](Link& link) { link = {}; }, IsEmpty()},  // virtual
      {[](Link& link) { link.carries_fd = true; }, IsEmpty(), fd},
      {[](Link&) {}, ElementsAre(Named("no_can_fd", "can0")), fd},
      {[](Link& link) { link = {.is_can = false}; },
       ElementsAre(Named("interface_not_can", "can0"))},
      {[](Link& link) { link.is_up = false, link.controller->health = stopped; },
       ElementsAre(Named("interface_down", "", "sudo ip link set can0 up"))},
      // An interface without a bit rate is not reported as down, too.
      {[](Link& link) {
         link.is_up = false;
         link.controller->bit_timing.reset();
         link.controller->restart_ms = 0;
       },
       ElementsAre(Named("no_bit_rate", "", set_up))},
      {[](Link& link) { link.controller->restart_ms = 0; },
       ElementsAre(Named("no_restart", "", HasSubstr("ip link set can0 type can restart-ms 100")))},
      {[](Link& link) { link.controller->health = bus_off; },
       ElementsAre(Named("bus_off", "", HasSubstr("set can0 down and up")))},
  };
  for (const Case& one : cases) {
    Link link = sound_link();
    one.change(link);
    EXPECT_THAT(examine_link("can0", link, one.needed), one.found) << &one - cases;
  }
  for (const auto health : {error_warning, error_passive}) {
    Link link = sound_link();
    link.controller->errors = can_berr_counter{.txerr = 3, .rxerr = 131};
    link.controller->health = health;
    EXPECT_THAT(examine_link("can0", link),
                ElementsAre(AllOf(Named("bus_errors", "131", HasSubstr("bit rate of can0")),
                                  Named("bus_errors", std::string{can::name_of(health)}))));
  }
}

TEST(Link, IsReadEvenIfMissingOrOfAnotherKind) {
  EXPECT_THAT(examine_link("can7", std::nullopt), ElementsAre(Named("interface_missing", "can7")));
  EXPECT_FALSE(read_link("no-such-bus"));
  ASSERT_TRUE(read_link("lo"));
  EXPECT_FALSE(read_link("lo")->is_can);
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

void other_format(Drive& drive) {
  for (can::Frame& frame : drive.frames)
    if (frame.id == message_of(drive, "STEERING").id) frame.format = can::IdFormat::extended;
}
void other_rate(Drive& drive) {
  for (can::Message& message : drive.databases[0].messages)
    if (message.name == "IMU") message.cycle_time_ns = 2 * fault::cycle_ns;
}
void no_rate(Drive& drive) {
  for (can::Message& message : drive.databases[0].messages) message.cycle_time_ns = 0;
}
void damaged(Drive& drive) {
  for (can::Frame& frame : drive.frames) {
    if (frame.id == message_of(drive, "WHEELS_REAR").id) frame.length = 2;
    if (frame.id == message_of(drive, "IMU").id) frame.data[frame.length - 1U] ^= 0x55U;
  }
}

TEST(Traffic, GetsAFindingForEachMistake) {
  const std::string extended =
      std::to_string(0x8000'0000U + message_of(small_drive(), "STEERING").id);
  const std::pair<void (*)(Drive&), Found> cases[]{
      {[](Drive&) {}, IsEmpty()},
      {other_format, ElementsAre(Named("other_id_format", "STEERING", HasSubstr(extended)))},
      {other_rate,
       ElementsAre(Named("other_rate", "100 times", HasSubstr("\"GenMsgCycleTime\" BO_ 418 10;")))},
      {no_rate, IsEmpty()},
      {damaged, UnorderedElementsAre(Named("message_without_value", "WHEELS_REAR"),
                                     Named("message_without_value", "IMU"))}};
  for (const auto& [change, found] : cases) {
    Drive drive = small_drive();
    change(drive);
    EXPECT_THAT(examine_traffic(drive), found);
  }
}

TEST(Acknowledgement, IsMissingIfAListenerReceivesNothingOrOneFrameRepeatedly) {
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
  // A controller that may acknowledge frames, or a virtual bus, has no finding.
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
