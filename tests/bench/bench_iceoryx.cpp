// The same pose through iceoryx, for comparison: publisher and subscriber in one process, with the
// broker (iox-roudi) running, set up as in iceoryx's examples.
//
// The sample is odomd's output of a tick: odom_pose and odom_details. A take gives a pointer into
// shared memory; the reader reads three doubles there and releases the chunk, the least that a
// reader can do, while odom_latest, next to it in the table, copies the whole pose. iceoryx costs
// more because it queues samples, separately for each subscriber, and never overwrites a sample in
// use.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <thread>
#include <vector>

#include <iceoryx_posh/popo/publisher.hpp>
#include <iceoryx_posh/popo/subscriber.hpp>
#include <iceoryx_posh/runtime/posh_runtime.hpp>

#include "tests/bench/freshly_written.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing {
namespace {

constexpr std::size_t queue = 16;

struct Stage {
  iox::popo::Publisher<Record> publisher{{"odomd", "bench", "pose"}};
  iox::popo::Subscriber<Record> subscriber{{"odomd", "bench", "pose"}, options()};
  bench::Apart<Record> record{patterned(2, 2)};

  Stage() {
    using namespace std::chrono_literals;
    const auto deadline = std::chrono::steady_clock::now() + 10s;
    while (!publisher.hasSubscribers() ||
           subscriber.getSubscriptionState() != iox::SubscribeState::SUBSCRIBED) {
      if (std::chrono::steady_clock::now() > deadline)
        throw std::runtime_error("iceoryx: not connected within 10 s");
      std::this_thread::sleep_for(1ms);
    }
  }

  static iox::popo::SubscriberOptions options() {
    iox::popo::SubscriberOptions options;
    options.queueCapacity = queue;
    return options;
  }

  /// Loans a chunk, copies the record into it, publishes it.
  void publish() {
    ++record.value.pose.tick;
    if (publisher.publishCopyOf(record.value).has_error())
      throw std::runtime_error("iceoryx: no chunk to loan");
  }

  void take() {
    const auto sample = subscriber.take();
    if (sample.has_error()) throw std::runtime_error("iceoryx: nothing to take");
    benchmark::DoNotOptimize(sample.value()->pose.x);
    benchmark::DoNotOptimize(sample.value()->pose.y);
    benchmark::DoNotOptimize(sample.value()->pose.yaw);
  }
};

/// A queue is filled and then emptied by one thread: all data stay in this core's cache.
void iceoryx_hot(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  using Nanoseconds = std::chrono::duration<double, std::nano>;
  Stage stage;
  std::vector<double> publish_ns;
  std::vector<double> take_ns;
  for (auto _ : state) {
    const auto start = Clock::now();
    for (std::size_t i = 0; i < queue; ++i) stage.publish();
    const auto published = Clock::now();
    for (std::size_t i = 0; i < queue; ++i) stage.take();
    const auto taken = Clock::now();
    publish_ns.push_back(Nanoseconds(published - start).count() / queue);
    take_ns.push_back(Nanoseconds(taken - published).count() / queue);
  }
  state.counters["publish_ns"] = bench::median(publish_ns);
  state.counters["p50_ns"] = bench::median(take_ns);
}
BENCHMARK(iceoryx_hot)->Iterations(20'000);

void iceoryx_fresh(benchmark::State& state) {
  Stage stage;
  bench::time_fresh_reads(
      state, [&](std::uint64_t) { stage.publish(); }, [&](std::uint64_t) { stage.take(); });
}
BENCHMARK(iceoryx_fresh)->UseManualTime()->Iterations(bench::fresh_reads);

}  // namespace
}  // namespace odomd::shm::testing

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  iox::runtime::PoshRuntime::initRuntime("odomd-bench");
  benchmark::RunSpecifiedBenchmarks();
}
