// Conversion of the kernel's frames, and the receive path on a socket that every machine has: a
// datagram socket on the loopback stamps, counts drops and batches like a CAN socket.
#include "can_protocol/sources/frame_receiver.hpp"

#include <arpa/inet.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "base/file_descriptor.hpp"
#include "base/wall_clock.hpp"
#include "can_protocol/sources/candump.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::frame_receiver_test {
namespace {

canfd_frame raw_frame(canid_t id, std::uint8_t length) {
  canfd_frame raw{};
  raw.can_id = id;
  raw.len = length;
  for (std::uint8_t i = 0; i < length; ++i) raw.data[i] = static_cast<std::uint8_t>(i + 1);
  return raw;
}

TEST(FromKernel, ReadsEveryKindOfFrame) {
  struct {
    canid_t id;
    std::uint8_t length;
    std::uint8_t flags;
    const char* candump;  ///< empty: no frame
  } const classic[]{
      {0x120, 8, 0, "120#0102030405060708"},
      {0x18DA'F110 | CAN_EFF_FLAG, 1, 0, "18DAF110#01"},
      {0x120 | CAN_RTR_FLAG, 4, 0, "120#R4"},
      {CAN_ERR_FLAG | CAN_ERR_CRTL, 8, 0, "20000004#0102030405060708"},
      {0x120, 9, 0, ""},
  },
      fd[]{
          {0x120, 12, CANFD_BRS | CANFD_FDF, "120##10102030405060708090A0B0C"},
          {0x120, 9, 0, ""},  // passed by a virtual bus, impossible on a real one
          {0x120, 65, 0, ""},
          {0x120 | CAN_RTR_FLAG, 12, 0, ""},
      };
  const auto expect_frame = [](const auto& row, std::size_t bytes) {
    canfd_frame raw = raw_frame(row.id, std::min<std::uint8_t>(row.length, 64));
    raw.len = row.length;
    raw.flags = row.flags;
    std::string text;
    if (const auto frame = from_kernel(raw, bytes)) {
      append_candump_line(text, *frame, "can0");
      EXPECT_EQ(frame->fd_flags, row.flags & CANFD_BRS);
      text = text.substr(text.find("can0 ") + 5, text.size() - text.find("can0 ") - 6);
    }
    EXPECT_EQ(text, row.candump) << row.id << ' ' << int{row.length};
  };
  for (const auto& row : classic) expect_frame(row, CAN_MTU);
  for (const auto& row : fd) expect_frame(row, CANFD_MTU);
  EXPECT_EQ(from_kernel(raw_frame(0x120 | CAN_RTR_FLAG, 4), CAN_MTU)->data[0], 0);
  EXPECT_FALSE(from_kernel(raw_frame(0x120, 8), CAN_MTU - 1));
  EXPECT_FALSE(from_kernel(raw_frame(0x120, 8), 0));
}

TEST(ExactFilters, MatchOnlyTheirDataFrames) {
  const std::vector<std::uint32_t> keys{frame_key(0x120, IdFormat::standard),
                                        frame_key(0x120, IdFormat::extended),
                                        frame_key(0x120, IdFormat::standard)};
  const auto filters = exact_filters(keys);
  ASSERT_EQ(filters.size(), 2U);
  const auto passes = [&](canid_t id) {
    int matches = 0;
    for (const can_filter& filter : filters)
      matches += (id & filter.can_mask) == (filter.can_id & filter.can_mask) ? 1 : 0;
    return matches;
  };
  EXPECT_EQ(passes(0x120), 1);
  EXPECT_EQ(passes(0x120 | CAN_EFF_FLAG), 1);
  EXPECT_EQ(passes(0x121), 0);
  EXPECT_EQ(passes(0x120 | CAN_RTR_FLAG), 0);
  EXPECT_EQ(passes(0x0001'0120 | CAN_EFF_FLAG), 0);
}

TEST(ExactFilters, AreEmptyBeyondTheKernelsLimit) {
  std::vector<std::uint32_t> keys;
  for (std::uint32_t id = 0; id < CAN_RAW_FILTER_MAX; ++id) keys.push_back(id);
  EXPECT_EQ(exact_filters(keys).size(), std::size_t{CAN_RAW_FILTER_MAX});
  keys.push_back(CAN_RAW_FILTER_MAX);
  EXPECT_TRUE(exact_filters(keys).empty());
  EXPECT_TRUE(exact_filters({}).empty());
}

TEST(DropCount, SurvivesTheWrapOfTheKernelsCounter) {
  DropCount drops;
  EXPECT_EQ(drops.grown_to(5), 5U);
  EXPECT_EQ(drops.grown_to(5), 0U);
  EXPECT_EQ(drops.grown_to(0xFFFF'FFFE), 0xFFFF'FFF9U);
  EXPECT_EQ(drops.grown_to(3), 5U);
  drops.restart();
  EXPECT_EQ(drops.grown_to(2), 2U);
}

// The receive path --------------------------------------------------------------------------------

class FrameReceiverTest : public testing::Test {
 protected:
  FrameReceiverTest()
      : receiving_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
        sending_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(receiving_.get(), generic, size), 0);
    EXPECT_EQ(::getsockname(receiving_.get(), generic, &size), 0);
    EXPECT_EQ(::connect(sending_.get(), generic, size), 0);
  }

  void send(const canfd_frame& raw, std::size_t bytes = CAN_MTU) const {
    ASSERT_EQ(::send(sending_.get(), &raw, bytes, 0), static_cast<ssize_t>(bytes));
  }
  std::vector<Frame> receive(FrameReceiver& receiver, std::size_t room = max_frames_per_drain) {
    std::vector<Frame> frames(room);
    const Received received = receiver.receive(receiving_.get(), frames, counters_);
    EXPECT_EQ(received.error, 0);
    frames.resize(received.count);
    return frames;
  }
  /// Waits for stamps: the kernel begins to stamp shortly after the first request.
  void await_stamps() {
    ASSERT_TRUE(request_stamps(receiving_.get(), StampSource::software));
    FrameReceiver receiver(0, StampSource::software);
    std::array<Frame, 1> frames;
    for (int attempt = 0; attempt < 20'000; ++attempt) {
      SourceCounters counters;
      send(raw_frame(0, 0));
      receiver.receive(receiving_.get(), frames, counters);
      if (counters.received.get() == 1 && counters.stamp_fallbacks.get() == 0) return;
      ::usleep(1000);
    }
    FAIL() << "no stamps";
  }

  FileDescriptor receiving_;
  FileDescriptor sending_;
  SourceCounters counters_;
  FrameReceiver receiver_{0, StampSource::software};
};

TEST_F(FrameReceiverTest, StampsFramesOnTheMonotonicClock) {
  await_stamps();
  FrameReceiver receiver(3, StampSource::software);
  const std::int64_t before = monotonic_now();
  for (canid_t id = 0; id < 10; ++id) send(raw_frame(id, 8));
  const auto frames = receive(receiver);
  const std::int64_t after = monotonic_now();
  ASSERT_EQ(frames.size(), 10U);
  std::int64_t last = before - 50'000;
  for (canid_t id = 0; id < 10; ++id) {
    EXPECT_EQ(frames[id].id, id);
    EXPECT_EQ(frames[id].bus, 3);
    EXPECT_GE(frames[id].time_ns, last);
    EXPECT_LE(frames[id].time_ns, after);
    last = frames[id].time_ns;
  }
  EXPECT_EQ(counters_.received.get(), 10U);
  EXPECT_EQ(counters_.stamp_fallbacks.get(), 0U);
  EXPECT_EQ(counters_.lost.get(), 0U);
}

TEST_F(FrameReceiverTest, FallsBackIfAStampIsMissing) {
  {
    FrameReceiver receiver(0, StampSource::software);
    send(raw_frame(1, 0));
    const std::int64_t before = monotonic_now();
    const auto frames = receive(receiver);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_GE(frames[0].time_ns, before) << "the time of its drain";
    EXPECT_LE(frames[0].time_ns, monotonic_now());
    EXPECT_EQ(counters_.stamp_fallbacks.get(), 1U);
  }
  await_stamps();
  ASSERT_TRUE(request_stamps(receiving_.get(), StampSource::hardware));
  FrameReceiver receiver(0, StampSource::hardware);
  send(raw_frame(1, 0));
  ASSERT_EQ(receive(receiver).size(), 1U);
  EXPECT_EQ(counters_.hardware_fallbacks.get(), 1U);
  EXPECT_EQ(counters_.stamp_fallbacks.get(), 1U) << "a software stamp";
}

TEST_F(FrameReceiverTest, CarriesOverFramesThatDoNotFit) {
  ASSERT_TRUE(request_stamps(receiving_.get(), StampSource::software));
  for (canid_t id = 0; id < 100; ++id) send(raw_frame(id, 8));
  canid_t next = 0;
  for (const std::size_t room : {30U, 30U, 30U, 30U})
    for (const Frame& frame : receive(receiver_, room)) EXPECT_EQ(frame.id, next++);
  EXPECT_EQ(next, 100U);
  EXPECT_EQ(counters_.carried_over.get(), 3U);
  EXPECT_TRUE(receive(receiver_).empty());
}

TEST_F(FrameReceiverTest, LimitsTheFramesPerCall) {
  const int large = 8 << 20;  // the kernel grants less, but enough for these frames
  ASSERT_EQ(::setsockopt(receiving_.get(), SOL_SOCKET, SO_RCVBUF, &large, sizeof large), 0);
  for (canid_t id = 0; id < 300; ++id) send(raw_frame(id, 8));
  EXPECT_EQ(receive(receiver_, 5000).size(), max_frames_per_drain);
  EXPECT_EQ(receive(receiver_, 5000).size(), 300 - max_frames_per_drain);
}

TEST_F(FrameReceiverTest, CountsFramesThatTheKernelDropped) {
  const int small = 4096;
  ASSERT_EQ(::setsockopt(receiving_.get(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small), 0);
  ASSERT_TRUE(request_stamps(receiving_.get(), StampSource::software));
  constexpr std::uint64_t sent = 200;
  for (canid_t id = 0; id < sent; ++id) send(raw_frame(id, 8));
  std::size_t received = receive(receiver_).size();
  EXPECT_LT(received, sent);
  // The kernel reports the count with the next frame that it does not drop.
  send(raw_frame(0x7FF, 0));
  received += receive(receiver_).size();
  EXPECT_EQ(received + counters_.lost.get(), sent + 1);
}

TEST_F(FrameReceiverTest, CountsErrorFramesAndMalformedFrames) {
  canfd_frame overflow = raw_frame(CAN_ERR_FLAG | CAN_ERR_CRTL, 8);
  overflow.data[1] = CAN_ERR_CRTL_RX_OVERFLOW;
  send(overflow);
  send(raw_frame(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8));
  send(raw_frame(0x120, 8), 5);
  send(raw_frame(0x120, 64), CANFD_MTU);
  const auto frames = receive(receiver_);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].length, 64);
  EXPECT_EQ(counters_.error_frames.get(), 2U);
  EXPECT_EQ(counters_.bus_offs.get(), 1U);
  EXPECT_EQ(counters_.controller_overflows.get(), 1U);
  EXPECT_EQ(counters_.malformed.get(), 1U);
  EXPECT_EQ(counters_.received.get(), 1U);
}

TEST_F(FrameReceiverTest, LeavesNothingOfALongFrameInAShortOne) {
  send(raw_frame(0x120, 64), CANFD_MTU);
  receive(receiver_);
  send(raw_frame(0x121, 1));
  const auto frames = receive(receiver_);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].data[0], 1);
  for (std::size_t i = 1; i < max_payload; ++i) EXPECT_EQ(frames[0].data[i], 0);
}

TEST_F(FrameReceiverTest, ReportsTheErrorOfItsSocket) {
  std::array<Frame, 4> frames;
  EXPECT_EQ(receiver_.receive(-1, frames, counters_).error, EBADF);
  EXPECT_EQ(receiver_.receive(receiving_.get(), frames, counters_).error, 0);  // no frame is there
}

}  // namespace
}  // namespace odomd::can::frame_receiver_test
