// The SocketCAN source on real (virtual) buses: every kind of frame, filters, a stepped clock, and
// links that go down, vanish and come back. Needs root and a kernel with vcan; makes its own buses.
// The receive path itself is tested on any machine, in tests/can_protocol/sources.
#include "can_protocol/sources/socketcan.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <thread>

#include "base/file_descriptor.hpp"
#include "base/wall_clock.hpp"
#include "can_protocol/frame.hpp"
#include "tests/gtest.hpp"

namespace odomd::can {
namespace {

const std::string bus_name = "odomtest0";
constexpr auto timeout = std::chrono::seconds(20);

[[nodiscard]] bool run(const std::string& command) {
  return std::system(command.c_str()) == 0;
}

/// The other end of the bus: a raw socket that may send.
class Peer {
 public:
  Peer() : socket_(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)) {
    const int on = 1;
    ::setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(bus_name.c_str()));
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }

  void send(const canfd_frame& raw, std::size_t bytes) const {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    while (::write(socket_.get(), &raw, bytes) != static_cast<ssize_t>(bytes)) {
      ASSERT_EQ(errno, ENOBUFS);
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      std::this_thread::yield();
    }
  }
  void send(canid_t id, std::uint8_t length = 8) const {
    canfd_frame raw{};
    raw.can_id = id;
    raw.len = length;
    for (std::uint8_t i = 0; i < length; ++i) raw.data[i] = static_cast<std::uint8_t>(i + 1);
    send(raw, CAN_MTU);
  }

 private:
  FileDescriptor socket_;
};

class SocketCan : public testing::Test {
 protected:
  SocketCan() { remove_bus(); }
  ~SocketCan() override { remove_bus(); }

  static void add_bus(const std::string& options = "") {
    ASSERT_TRUE(run("ip link add " + bus_name + " " + options + " type vcan"));
    ASSERT_TRUE(run("ip link set " + bus_name + " mtu 72 up"));
  }
  static void remove_bus() { (void)run("ip link del " + bus_name + " 2>/dev/null"); }
  static void set_link(const std::string& state) {
    ASSERT_TRUE(run("ip link set " + bus_name + " " + state));
  }
  static std::vector<Frame> drain(SocketCanSource& source) {
    std::vector<Frame> frames(max_frames_per_drain);
    const std::int64_t time = monotonic_now();
    frames.resize(source.drain(frames, time, time));
    return frames;
  }
  /// Drains until this holds for the frames so far, or a time limit is reached.
  template <typename Done>
  static std::vector<Frame> drain_until(SocketCanSource& source, const Done& done) {
    std::vector<Frame> all;
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    while (!done(all) && std::chrono::steady_clock::now() < deadline) {
      const auto some = drain(source);
      all.insert(all.end(), some.begin(), some.end());
      if (some.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return all;
  }
  static std::vector<Frame> drain_frames(SocketCanSource& source, std::size_t count) {
    return drain_until(source, [&](const auto& frames) { return frames.size() >= count; });
  }
  static bool reaches(SocketCanSource& source, LinkState state) {
    drain_until(source, [&](const auto&) { return source.link() == state; });
    return source.link() == state;
  }
  /// Whether housekeeping finds the link up, and a frame arrives.
  static bool hears(SocketCanSource& source) {
    source.maintain();
    if (source.link() != LinkState::up) return false;
    drain(source);  // begins to use a new socket
    Peer().send(0x120);
    return drain_frames(source, 1).size() == 1;
  }
  /// Waits for stamps: the kernel begins to stamp shortly after the first request.
  static void await_stamps(SocketCanSource& source, const Peer& peer) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    for (std::uint64_t before = 1, after = 0; before != after;) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      before = source.counters().stamp_fallbacks.get();
      peer.send(0x7FF, 0);
      ASSERT_EQ(drain_frames(source, 1).size(), 1U);
      after = source.counters().stamp_fallbacks.get();
    }
  }
  static SocketCanSettings settings(std::vector<std::uint32_t> keys = {}) {
    SocketCanSettings result;
    result.bus = 5;
    result.keys = std::move(keys);
    return result;
  }
};

TEST_F(SocketCan, DeliversEveryKindOfFrame) {
  add_bus();
  SocketCanSource source(bus_name, settings());
  EXPECT_EQ(source.link(), LinkState::up);
  EXPECT_EQ(source.name(), bus_name);
  const Peer peer;
  peer.send(0x123, 3);
  peer.send(0x18DA'F110 | CAN_EFF_FLAG, 8);
  peer.send(0x124 | CAN_RTR_FLAG, 4);
  peer.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF);
  canfd_frame fd{};
  fd.can_id = 0x125;
  fd.len = 64;
  fd.data[63] = 0xAB;
  peer.send(fd, CANFD_MTU);

  const auto frames = drain_frames(source, 4);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].id, 0x123U);
  EXPECT_EQ(frames[0].length, 3);
  EXPECT_EQ(frames[0].bus, 5);
  EXPECT_EQ(frames[1].id, 0x18DA'F110U);
  EXPECT_EQ(frames[2].kind, FrameKind::remote);
  EXPECT_EQ(frames[3].data[63], 0xAB);
  EXPECT_EQ(source.counters().received.get(), 4U);
  EXPECT_EQ(source.counters().bus_offs.get(), 1U);
  EXPECT_EQ(source.counters().malformed.get(), 0U);
}

TEST_F(SocketCan, LetsTheKernelFilterByExactIdentifier) {
  add_bus();
  SocketCanSource source(bus_name, settings({frame_key(0x120, IdFormat::standard),
                                             frame_key(0x1'0130, IdFormat::extended)}));
  const Peer peer;
  for (canid_t id = 0; id <= 0x7FF; ++id) peer.send(id, 1);
  peer.send(0x120 | CAN_EFF_FLAG);
  peer.send(0x120 | CAN_RTR_FLAG);
  peer.send(0x1'0130 | CAN_EFF_FLAG);
  const auto frames = drain_frames(source, 2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].id, 0x120U);
  EXPECT_EQ(frames[0].format, IdFormat::standard);
  EXPECT_EQ(frames[1].id, 0x1'0130U);
  EXPECT_TRUE(drain(source).empty());
}

TEST_F(SocketCan, ConvertsStampsAcrossASteppedWallClock) {
  if (std::getenv("LAB_SHARED") == nullptr) {  // never change the clock of a machine in use
    std::puts("not run: 1");
    return;
  }
  add_bus();
  SocketCanSource source(bus_name, settings());
  const Peer peer;
  await_stamps(source, peer);
  const std::uint64_t fallbacks = source.counters().stamp_fallbacks.get();
  for (const std::int64_t step_s : {3600, -7200, 30, -30, 86'400, -82'800}) {
    drain(source);
    const std::int64_t before = monotonic_now();
    peer.send(0x1);
    timespec wall{};
    ::clock_gettime(CLOCK_REALTIME, &wall);
    wall.tv_sec += step_s;
    ASSERT_EQ(::clock_settime(CLOCK_REALTIME, &wall), 0);
    peer.send(0x2);
    const std::int64_t sent = monotonic_now();
    const auto frames = drain_frames(source, 2);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_GE(frames[0].time_ns, before - 100'000);
    EXPECT_GE(frames[1].time_ns, frames[0].time_ns);
    EXPECT_LE(frames[1].time_ns, sent + 100'000);
  }
  EXPECT_EQ(source.counters().clock_steps.get(), 6U);
  EXPECT_EQ(source.counters().suspends.get(), 0U);
  EXPECT_EQ(source.counters().stamp_fallbacks.get(), fallbacks);
}

TEST_F(SocketCan, GetsTheReceiveBufferItAsksFor) {
  add_bus();
  SocketCanSettings large = settings();
  large.receive_buffer = 8 << 20;
  SocketCanSource source(bus_name, large);
  EXPECT_TRUE(source.warnings().empty());
  const Peer peer;
  for (int i = 0; i < 5000; ++i) peer.send(0x120);
  EXPECT_EQ(drain_frames(source, 5000).size(), 5000U);
  EXPECT_EQ(source.counters().lost.get(), 0U);
}

TEST_F(SocketCan, SurvivesALinkThatGoesDownOrVanishesAndComesBack) {
  for (const bool vanishes : {false, true}) {
    SCOPED_TRACE(vanishes ? "vanishes" : "goes down");
    add_bus();
    SocketCanSource source(bus_name, settings());
    for (std::uint64_t round = 1; round <= 3; ++round) {
      vanishes ? remove_bus() : set_link("down");
      const LinkState broken = vanishes ? LinkState::gone : LinkState::down;
      EXPECT_TRUE(reaches(source, broken));
      source.maintain();
      EXPECT_EQ(source.link(), broken);
      const std::uint64_t downs = source.counters().link_downs.get();
      EXPECT_TRUE(vanishes ? downs >= round : downs == round) << downs;
      vanishes ? add_bus() : set_link("up");
      EXPECT_TRUE(hears(source));
    }
    remove_bus();
  }
}

TEST_F(SocketCan, WaitsForALinkThatIsMissingOrDown) {
  for (const bool missing : {false, true}) {
    SCOPED_TRACE(missing ? "missing" : "down");
    if (!missing) {
      add_bus();
      set_link("down");
    }
    SocketCanSource source(bus_name, settings());
    const LinkState expected = missing ? LinkState::gone : LinkState::down;
    EXPECT_EQ(source.link(), expected);
    EXPECT_TRUE(drain(source).empty());
    source.maintain();
    EXPECT_EQ(source.link(), expected);
    missing ? add_bus() : set_link("up");
    EXPECT_TRUE(hears(source));
    EXPECT_EQ(source.counters().link_downs.get(), 0U);
    remove_bus();
  }
}

TEST_F(SocketCan, DetectsAnInterfaceThatReturnsWithItsOldIndex) {
  add_bus("index 4711");
  SocketCanSource source(bus_name, settings());
  remove_bus();
  add_bus("index 4711");
  EXPECT_TRUE(reaches(source, LinkState::gone));
  EXPECT_TRUE(hears(source));
}

TEST_F(SocketCan, ReplacesSocketsDuringDrainsWithoutALeak) {
  add_bus();
  SocketCanSource source(bus_name, settings());
  const auto open_descriptors = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  };
  const auto before = open_descriptors();
  std::atomic<bool> stop{false};
  std::thread beat([&] {
    std::array<Frame, max_frames_per_drain> frames;
    while (!stop) source.drain(frames, monotonic_now(), monotonic_now());
  });
  for (int round = 0; round < 10; ++round) {
    remove_bus();
    source.maintain();
    add_bus();
    source.maintain();
    source.maintain();
  }
  stop = true;
  beat.join();
  drain(source);
  source.maintain();
  EXPECT_EQ(open_descriptors(), before);
  EXPECT_TRUE(hears(source));
}

TEST_F(SocketCan, RefusesAnInterfaceThatIsNotCan) {
  EXPECT_THROW(SocketCanSource("lo", settings()), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::can
