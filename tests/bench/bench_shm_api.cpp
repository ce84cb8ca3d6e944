// What a pose costs: to publish, to read, and to copy by the same relaxed words for comparison.
//
// "hot" reads the same pose again and again. "freshly written" reads each pose once, after another
// core has written it: the price of the cache lines that have to come over.
#include <benchmark/benchmark.h>
#include <unistd.h>
#include <array>
#include <atomic>
#include <cstring>
#include <thread>

#include <odom/odom.hpp>

#include "shm_api/slot.h"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing {
namespace {

struct Stage {
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  Writer writer{{.name = path}, test_info()};
  ClientPointer client;

  Stage() {
    publish_patterned(writer, 1, 1);
    client = open_client(path);
    // Fresh for as long as the benchmark runs: nobody beats here.
    writer.set_heartbeat(now_ns());
  }
};

void publish(benchmark::State& state) {
  Stage stage;
  Record record = patterned(2, 2);
  for (auto _ : state) {
    ++record.pose.tick;
    stage.writer.publish(record.pose, record.details);
  }
}
BENCHMARK(publish);

void wake_without_waiters(benchmark::State& state) {
  Stage stage;
  for (auto _ : state) stage.writer.wake_clients();
}
BENCHMARK(wake_without_waiters);

// The yardstick: 28 relaxed words out of shared memory into the caller's.
void copy_relaxed_words(benchmark::State& state) {
  const std::array<std::uint64_t, ODOM_SLOT_WORDS> words{};
  odom_pose pose{};
  for (auto _ : state) {
    odomi_copy_out(&pose, words.data() + ODOM_SLOT_POSE, ODOM_POSE_WORDS);
    benchmark::DoNotOptimize(pose);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(copy_relaxed_words);

void copy_memcpy(benchmark::State& state) {
  const odom_pose from{};
  odom_pose pose{};
  for (auto _ : state) {
    benchmark::DoNotOptimize(from);
    std::memcpy(&pose, &from, sizeof pose);
    benchmark::DoNotOptimize(pose);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(copy_memcpy);

// The heartbeat is renewed once in a while, as a daemon does, so that the read is of a live one.
template <class Read>
void read_hot(benchmark::State& state, Stage& stage, const Read& read) {
  std::uint64_t reads = 0;
  for (auto _ : state) {
    if ((++reads & 0xFFFFU) == 0) stage.writer.set_heartbeat(now_ns());
    read();
  }
}

void latest(benchmark::State& state) {
  Stage stage;
  odom_pose pose{};
  read_hot(state, stage, [&] {
    benchmark::DoNotOptimize(odom_latest(stage.client.get(), &pose, sizeof pose));
    benchmark::DoNotOptimize(pose);
  });
}
BENCHMARK(latest);

void latest_with_details(benchmark::State& state) {
  Stage stage;
  odom_pose pose{};
  odom_details details{};
  read_hot(state, stage, [&] {
    benchmark::DoNotOptimize(
        odom_latest_details(stage.client.get(), &pose, sizeof pose, &details, sizeof details));
    benchmark::DoNotOptimize(pose);
    benchmark::DoNotOptimize(details);
  });
}
BENCHMARK(latest_with_details);

void in_place_x_y_yaw(benchmark::State& state) {
  Stage stage;
  read_hot(state, stage, [&] {
    odom_view view{};
    odom_begin(stage.client.get(), &view);
    benchmark::DoNotOptimize(odom_view_double(&view, ODOM_WORD_X));
    benchmark::DoNotOptimize(odom_view_double(&view, ODOM_WORD_Y));
    benchmark::DoNotOptimize(odom_view_double(&view, ODOM_WORD_YAW));
    benchmark::DoNotOptimize(odom_validate(&view));
  });
}
BENCHMARK(in_place_x_y_yaw);

void at_past_time(benchmark::State& state) {
  Stage stage;
  for (std::uint64_t tick = 2; tick <= 1000; ++tick)
    stage.writer.publish(moving_pose(tick), odom_details{});
  odom_pose pose{};
  const std::int64_t time_ns = 990 * period_ns + 1'000'000;
  read_hot(state, stage, [&] {
    benchmark::DoNotOptimize(odom_at(stage.client.get(), time_ns, &pose, sizeof pose));
  });
}
BENCHMARK(at_past_time);

void predict_35_ms(benchmark::State& state) {
  odom_pose from = moving_pose(1);
  from.yaw_rate = 3.0;
  from.yaw_accel = 1.0;
  odom_pose to{};
  for (auto _ : state) {
    benchmark::DoNotOptimize(odom_predict(&from, from.time_ns + 35'000'000, &to));
    benchmark::DoNotOptimize(to);
  }
}
BENCHMARK(predict_35_ms);

// Another thread publishes one pose on demand; only the read is timed.
template <class Read>
void read_freshly_written(benchmark::State& state, const Read& read) {
  Stage stage;
  std::atomic<std::uint64_t> asked{0};
  std::atomic<std::uint64_t> done{0};
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    Record record = patterned(2, 2);
    std::uint64_t served = 0;
    while (!stop.load(std::memory_order_relaxed)) {
      if (asked.load(std::memory_order_acquire) == served) continue;
      ++record.pose.tick;
      stage.writer.publish(record.pose, record.details);
      stage.writer.set_heartbeat(now_ns());
      done.store(++served, std::memory_order_release);
    }
  });
  std::uint64_t wanted = 0;
  for (auto _ : state) {
    asked.store(++wanted, std::memory_order_release);
    while (done.load(std::memory_order_acquire) != wanted) {
    }
    const auto start = std::chrono::steady_clock::now();
    read(stage);
    const auto end = std::chrono::steady_clock::now();
    state.SetIterationTime(std::chrono::duration<double>(end - start).count());
  }
  stop = true;
  writer.join();
}

void latest_freshly_written(benchmark::State& state) {
  odom_pose pose{};
  read_freshly_written(state, [&](Stage& stage) {
    benchmark::DoNotOptimize(odom_latest(stage.client.get(), &pose, sizeof pose));
  });
}
BENCHMARK(latest_freshly_written)->UseManualTime()->Iterations(200000);

// What of the time above is that of the two clock readings around it.
void nothing_freshly_written(benchmark::State& state) {
  read_freshly_written(state, [](Stage&) {});
}
BENCHMARK(nothing_freshly_written)->UseManualTime()->Iterations(200000);

}  // namespace
}  // namespace odomd::shm::testing
