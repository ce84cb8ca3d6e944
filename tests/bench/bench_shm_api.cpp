// Cost of a pose: publishing, reading, and, for comparison, copying with the same relaxed loads.
//
// Reads are hot (the same pose repeatedly) or fresh (freshly_written.hpp): each pose once, after
// another core has written it.
#include <benchmark/benchmark.h>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include <odom/odom.hpp>

#include "shm_api/layout/slot.h"
#include "tests/bench/freshly_written.hpp"
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
    // Makes the writer fresh at the start of the benchmark; read_hot() renews the heartbeat.
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

// For comparison: copies 28 relaxed words from shared memory to the caller.
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

// Renews the heartbeat from time to time, so that the reader sees a live daemon.
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

void look_in_place(Stage& stage) {
  odom_view view{};
  odom_begin(stage.client.get(), &view);
  benchmark::DoNotOptimize(odom_view_double(&view, ODOM_WORD_X));
  benchmark::DoNotOptimize(odom_view_double(&view, ODOM_WORD_Y));
  benchmark::DoNotOptimize(odom_view_double(&view, ODOM_WORD_YAW));
  benchmark::DoNotOptimize(odom_validate(&view));
}

void in_place(benchmark::State& state) {
  Stage stage;
  read_hot(state, stage, [&] { look_in_place(stage); });
}
BENCHMARK(in_place);

/// Another thread publishes before every read.
template <class Read>
void read_fresh(benchmark::State& state, const Read& read) {
  Stage stage;
  bench::Apart<Record> record{patterned(2, 2)};
  bench::time_fresh_reads(
      state,
      [&](std::uint64_t n) {
        record.value.pose.tick = n + 1;
        stage.writer.publish(record.value.pose, record.value.details);
        stage.writer.set_heartbeat(now_ns());
      },
      [&](std::uint64_t) { read(stage); });
}

void latest_fresh(benchmark::State& state) {
  bench::Apart<odom_pose> pose{};
  read_fresh(state, [&](Stage& stage) {
    benchmark::DoNotOptimize(odom_latest(stage.client.get(), &pose.value, sizeof pose.value));
    benchmark::DoNotOptimize(pose);
  });
}
BENCHMARK(latest_fresh)->UseManualTime()->Iterations(bench::fresh_reads);

void in_place_fresh(benchmark::State& state) {
  read_fresh(state, [&](Stage& stage) { look_in_place(stage); });
}
BENCHMARK(in_place_fresh)->UseManualTime()->Iterations(bench::fresh_reads);

// For comparison, freshly written: 28 words in the same ring of slots, without sequence, head and
// heartbeat.
template <class Copy>
void copy_fresh(benchmark::State& state, const Copy& copy) {
  constexpr std::size_t slots = 1024;
  std::vector<std::uint64_t> ring(slots * ODOM_SLOT_WORDS);
  bench::Apart<Record> record{patterned(2, 2)};
  const auto slot = [&](std::uint64_t n) { return ring.data() + n % slots * ODOM_SLOT_WORDS; };
  bench::Apart<odom_pose> pose{};
  bench::time_fresh_reads(
      state,
      [&](std::uint64_t n) {
        record.value.pose.tick = n;
        odomi_copy_in(slot(n), &record.value.pose, ODOM_POSE_WORDS);
      },
      [&](std::uint64_t n) {
        copy(pose.value, slot(n));
        benchmark::DoNotOptimize(pose);
      });
}

void copy_relaxed_words_fresh(benchmark::State& state) {
  copy_fresh(state, [](odom_pose& to, const std::uint64_t* from) {
    odomi_copy_out(&to, from, ODOM_POSE_WORDS);
  });
}
BENCHMARK(copy_relaxed_words_fresh)->UseManualTime()->Iterations(bench::fresh_reads);

void copy_memcpy_fresh(benchmark::State& state) {
  copy_fresh(state, [](odom_pose& to, const std::uint64_t* from) {
    std::memcpy(static_cast<void*>(&to), from, sizeof to);
  });
}
BENCHMARK(copy_memcpy_fresh)->UseManualTime()->Iterations(bench::fresh_reads);

// The cost of the two clock readings in each of the times above.
void nothing_fresh(benchmark::State& state) {
  read_fresh(state, [](Stage&) {});
}
BENCHMARK(nothing_fresh)->UseManualTime()->Iterations(bench::fresh_reads);

}  // namespace
}  // namespace odomd::shm::testing
