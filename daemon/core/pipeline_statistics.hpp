// Counters of a pipeline, by source and by frame: any thread may read them while the beat runs.
#pragma once

#include <array>

#include "base/counter.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "daemon/core/innovation_statistics.hpp"
#include "daemon/core/noise_statistics.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

struct SourceStatistics {
  std::array<Counter, estimator::verdict_count> verdicts;
  Counter last_time_ns;     ///< when the newest sample was taken (bit pattern of the signed time)
  Counter last_verdict;     ///< an estimator::Verdict
  Counter flag;             ///< an estimator::SourceFlag, at the last tick
  Counter wiring;           ///< a WiringFault, at the last tick
  Counter inconsistent;     ///< 1: at the last tick the NIS had been too large for seconds
  Counter last_latency_ns;  ///< camera only: from the capture of the newest pose to its arrival
  Counter last_test_ratio;  ///< camera only: νᵀS⁻¹ν / gate (bit pattern of the double)
  InnovationStatistics innovations;  ///< for models that test each sample
  NoiseStatistics noise;             ///< at the last tick, for models that estimate it
};

struct PipelineStatistics {
  std::array<SourceStatistics, estimator::source_count> sources;
  std::array<Counter, can::frame_verdict_count> frames;
  std::array<Counter, can::stamp_verdict_count> stamps;
  Counter camera_malformed;  ///< messages with a wrong size, magic, version or clock
};

}  // namespace odomd::daemon
