#include "can_protocol/sources/live_stamps.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::live_stamps_test {
namespace {

constexpr std::int64_t s = 1'000'000'000;
constexpr std::int64_t stamp = 1'700'000'000 * s;
using Input = LiveStamps::Input;

class LiveStampsTest : public testing::Test {
 protected:
  /// Ten frames at intervals of 10 ms.
  void run(Input input) {
    for (int i = 0; i < 10; ++i) {
      stamp_ += s / 100;
      now_ += s / 100;
      stamps_.read(input);
      EXPECT_FALSE(stamps_.step(stamp_, now_));
    }
  }
  LiveStamps stamps_;
  std::int64_t stamp_ = stamp;
  std::int64_t now_ = 5000 * s;
};

TEST_F(LiveStampsTest, AClockThatIsSetIsNoticedInEitherDirection) {
  run(Input::waited_for);
  EXPECT_EQ(stamps_.step(stamp_ += 3600 * s, now_), 3600 * s);
  run(Input::waited_for);
  EXPECT_EQ(stamps_.step(stamp_ -= 7200 * s, now_), -7200 * s);
  run(Input::waited_for);
  EXPECT_EQ(stamps_.step(stamp_ += 2 * s, now_), 2 * s);
}

TEST_F(LiveStampsTest, APauseOfTheBusIsNoStep) {
  run(Input::waited_for);
  EXPECT_FALSE(stamps_.step(stamp_ += 3600 * s, now_ += 3600 * s));
}

TEST_F(LiveStampsTest, FramesThatWereKeptBackAreNoStep) {
  run(Input::waited_for);
  EXPECT_FALSE(stamps_.step(stamp_ += s / 100, now_ += 20 * s));
  EXPECT_FALSE(stamps_.step(stamp_ += s / 100, now_));
  EXPECT_FALSE(stamps_.step(stamp_ -= s / 2, now_));  // a frame out of order: no step either
}

TEST_F(LiveStampsTest, ALogThatIsPipedInKeepsItsPauses) {
  stamps_.read(Input::waited_for);  // waits for the pipe to open
  run(Input::ready);
  EXPECT_FALSE(stamps_.step(stamp_ += 3600 * s, now_));
  EXPECT_FALSE(stamps_.step(stamp_ -= 3600 * s, now_));
}

TEST_F(LiveStampsTest, TheFirstStampIsNoStep) {
  for (int i = 0; i < 8; ++i) stamps_.read(Input::waited_for);
  EXPECT_FALSE(stamps_.step(stamp, now_));
}

}  // namespace
}  // namespace odomd::can::live_stamps_test
