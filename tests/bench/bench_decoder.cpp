// Cost of decoding: unmapped frames, bound frames, protected frames.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdint>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/decode/message_encoder.hpp"

namespace odomd::can {
namespace {

constexpr const char* bus = R"(BO_ 418 IMU: 8 X
 SG_ CRC : 0|8@1+ (1,0) [0|0] "" X
 SG_ Counter : 8|4@1+ (1,0) [0|0] "" X
 SG_ YawRate : 12|18@1- (0.0002,0) [0|0] "rad/s" X
 SG_ AccX : 30|17@1- (0.0025,0) [0|0] "m/s2" X
 SG_ AccY : 47|17@1- (0.0025,0) [0|0] "m/s2" X
)";

struct Rig {
  explicit Rig(E2eProfile profile) : databases{parse_dbc(bus, "bench.dbc")} {
    protection.message = "IMU";
    protection.profile = profile;
    protection.data_id = 418;
    protection.crc_signal = "CRC";
    protection.counter_signal = "Counter";
    for (const char* signal : {"YawRate", "AccX", "AccY"}) {
      SignalBinding binding;
      binding.channel = static_cast<std::uint16_t>(bindings.size());
      binding.message = "IMU";
      binding.signals = {signal};
      bindings.push_back(binding);
    }
    MessageEncoder encoder(databases[0].messages[0], protection);
    for (std::size_t i = 0; i < std::size_t{15} * 64;
         ++i) {  // whole rounds of the counter, so that repetition shows no loss
      encoder.set("YawRate", 0.01 * static_cast<double>(i));
      frames.push_back(encoder.frame(static_cast<std::int64_t>(i)));
    }
  }

  std::vector<Database> databases;
  std::vector<SignalBinding> bindings;
  E2eBinding protection;
  std::vector<Frame> frames;
};

void decode_all(benchmark::State& state, const Rig& rig, std::span<const E2eBinding> protections) {
  Decoder decoder(rig.databases, rig.bindings, protections, {});
  std::array<Sample, max_samples_per_frame> samples{};
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(decoder.decode(rig.frames[i], samples));
    benchmark::DoNotOptimize(samples);
    i = i + 1 == rig.frames.size() ? 0 : i + 1;
  }
}

void decode_unmapped(benchmark::State& state) {
  Rig rig(E2eProfile::none);
  for (Frame& frame : rig.frames) ++frame.id;
  decode_all(state, rig, {});
}
BENCHMARK(decode_unmapped);

void decode_three_signals(benchmark::State& state) {
  decode_all(state, Rig(E2eProfile::none), {});
}
BENCHMARK(decode_three_signals);

void decode_three_signals_protected(benchmark::State& state) {
  const Rig rig(E2eProfile::p01);
  decode_all(state, rig, std::span(&rig.protection, 1));
}
BENCHMARK(decode_three_signals_protected);

}  // namespace
}  // namespace odomd::can
