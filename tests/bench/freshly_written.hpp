// Times reads of data that another core has just written: the instructions, and in addition the
// transfer of the cache lines.
//
// Before each read, a second thread makes one write; then only the read is timed, between two
// readings of the clock. The result is the median of the reads ("p50_ns"). It includes the clock
// readings; nothing_fresh measures their cost.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

namespace odomd::bench {

inline constexpr std::int64_t fresh_reads = 100'000;

/// One thread's data on its own cache lines, so that a write does not move the other's.
template <class T>
struct alignas(64) Apart {
  T value;
};

inline double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Calls `write(n)` for n = 1, 2, ... in a separate thread, and `read(n)` after each.
template <class Write, class Read>
void time_fresh_reads(benchmark::State& state, const Write& write, const Read& read) {
  using Clock = std::chrono::steady_clock;
  Apart<std::atomic<std::uint64_t>> asked{0};
  Apart<std::atomic<std::uint64_t>> written{0};
  constexpr std::uint64_t stop = ~std::uint64_t{0};
  std::thread writer([&] {
    std::uint64_t done = 0;
    for (std::uint64_t wanted = 0; wanted != stop;
         wanted = asked.value.load(std::memory_order_acquire)) {
      if (wanted == done) continue;
      write(++done);
      written.value.store(done, std::memory_order_release);
    }
  });

  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(state.max_iterations));
  std::uint64_t wanted = 0;
  for (auto _ : state) {
    asked.value.store(++wanted, std::memory_order_release);
    while (written.value.load(std::memory_order_acquire) != wanted) {
    }
    const auto start = Clock::now();
    read(wanted);
    const std::chrono::duration<double> time = Clock::now() - start;
    state.SetIterationTime(time.count());
    times.push_back(time.count() * 1e9);
  }
  asked.value.store(stop, std::memory_order_release);
  writer.join();

  state.counters["p50_ns"] = median(times);
}

}  // namespace odomd::bench
