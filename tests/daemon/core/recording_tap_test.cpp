// The tap between the beat and a recorder: which inputs belong to which tick, when a recording
// begins and ends, and that it ends when a ring is full.
#include "daemon/core/recording_tap.hpp"

#include <memory>

#include "daemon/core/pipeline.hpp"
#include "tests/allocation_count.hpp"
#include "tests/daemon/core/one_wheel.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::recording_tap_test {
namespace {

using State = RecordingTap::State;

class RecordingTapTest : public testing::Test {
 protected:
  RecordingTapTest() {
    config_.can.bindings = one_wheel::bindings();
    pipeline_ =
        std::make_unique<Pipeline>(config_, one_wheel::bus(), std::vector<std::string>{}, true);
    tap_ = std::make_unique<RecordingTap>(*pipeline_);
  }

  void tick(int frames, int cameras = 0) {
    ++tick_;
    for (int i = 0; i < frames; ++i) {
      const can::Frame frame{.time_ns = next_time_++, .id = 257, .length = 2};
      pipeline_->take(frame, next_time_);
      tap_->take(frame);
    }
    for (int i = 0; i < cameras; ++i) tap_->take(estimator::CameraPose{.capture_ns = next_time_++});
    const auto& record = pipeline_->tick(tick_, static_cast<std::int64_t>(tick_) * 5'000'000);
    tap_->tick_done(record, {static_cast<std::int64_t>(tick_), 7, 3}, *pipeline_);
  }
  /// Pops a tick; returns its number.
  std::uint64_t take_out() {
    const TickMark mark = *tap_->mark();
    for (std::uint32_t i = 0; i < mark.frames; ++i) last_taken_ = tap_->take_frame().time_ns;
    for (std::uint32_t i = 0; i < mark.cameras; ++i) last_taken_ = tap_->take_camera().capture_ns;
    tap_->pop_mark();
    return mark.record.pose.tick;
  }

  Config config_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<RecordingTap> tap_;
  std::uint64_t tick_ = 0;
  std::int64_t next_time_ = 1;
  std::int64_t last_taken_ = 0;
};

TEST_F(RecordingTapTest, StartsAfterATickWithItsState) {
  tick(2);
  tap_->begin();
  EXPECT_EQ(tap_->state(), State::wanted);
  tick(3, 1);  // the state includes the inputs of this tick
  ASSERT_EQ(tap_->state(), State::running);
  ASSERT_NE(tap_->mark(), nullptr);
  EXPECT_EQ(tap_->mark()->frames, 0U);
  EXPECT_EQ(tap_->mark()->cameras, 0U);
  EXPECT_EQ(tap_->mark()->record.details.frames[0], 5U);
  EXPECT_EQ(tap_->checkpoint().state.record.pose.tick, 2U);
  EXPECT_EQ(tap_->checkpoint().protections.size(), 1U);

  tick(4, 2);
  EXPECT_EQ(take_out(), 2U);
  ASSERT_NE(tap_->mark(), nullptr);
  EXPECT_EQ(tap_->mark()->frames, 4U);
  EXPECT_EQ(tap_->mark()->cameras, 2U);
  EXPECT_EQ(tap_->mark()->woke_ns, 3);
  EXPECT_EQ(tap_->mark()->realtime_offset_ns, 7);
  EXPECT_EQ(tap_->mark()->conditions, 3U);
  EXPECT_EQ(take_out(), 3U);
  EXPECT_EQ(last_taken_, next_time_ - 1);
  EXPECT_EQ(tap_->mark(), nullptr);
}

TEST_F(RecordingTapTest, EndsWithTheLastCompleteTickWhenFramesOverflow) {
  tap_->begin();
  tick(0);
  const int per_tick = 1000;
  const auto fit = RecordingTap::max_frames / per_tick;
  for (std::size_t i = 0; i < fit + 3; ++i) tick(per_tick);
  EXPECT_EQ(tap_->state(), State::full);
  std::uint64_t last = 0;
  std::uint64_t marks = 0;
  for (; tap_->mark() != nullptr; ++marks) last = take_out();
  EXPECT_EQ(marks, fit + 1);
  EXPECT_EQ(last, fit + 1);
  EXPECT_EQ(last_taken_, static_cast<std::int64_t>(fit) * per_tick);

  tick(1);  // there is room, but the recording has ended
  EXPECT_EQ(tap_->mark(), nullptr);
  EXPECT_EQ(tap_->state(), State::full);
}

TEST_F(RecordingTapTest, EndsWhenTicksOverflow) {
  tap_->begin();
  for (std::size_t i = 0; i < RecordingTap::max_ticks + 1; ++i) tick(0);
  EXPECT_EQ(tap_->state(), State::full);
  std::size_t marks = 0;
  for (; tap_->mark() != nullptr; ++marks) static_cast<void>(take_out());
  EXPECT_EQ(marks, RecordingTap::max_ticks);
}

TEST_F(RecordingTapTest, RestartsWithEmptyRingsAndAllocatesOnDemand) {
  tap_->begin();
  tap_->end();
  tick(5, 1);
  EXPECT_EQ(tap_->state(), State::idle) << "a wish that is taken back";
  EXPECT_EQ(tap_->mark(), nullptr);
  tap_->begin();
  tick(0);
  tick(3, 3);
  tap_->end();
  EXPECT_EQ(tap_->state(), State::unwanted);
  tick(2, 1);
  EXPECT_EQ(tap_->state(), State::idle);
  tap_->begin();
  EXPECT_EQ(tap_->mark(), nullptr);
  tick(1);
  tick(1, 1);
  EXPECT_EQ(take_out(), 5U);
  EXPECT_EQ(tap_->mark()->frames, 1U);
  EXPECT_EQ(tap_->mark()->cameras, 1U);
  EXPECT_EQ(take_out(), 6U);
  EXPECT_EQ(last_taken_, next_time_ - 1);
  tick(1);
  EXPECT_EQ(take_out(), 7U);
  EXPECT_EQ(last_taken_, next_time_ - 1);
}

TEST_F(RecordingTapTest, TheBeatDoesNotAllocate) {
  tap_->begin();  // called by housekeeping: allocates the rings
  const auto before = allocation_count();
  for (int i = 0; i < 300; ++i) tick(200, 20);  // beyond the rings' capacity
  tap_->end();
  tick(1);
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace odomd::daemon::recording_tap_test
