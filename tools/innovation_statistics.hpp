// How the samples of a drive agreed with the filter's expectation of them, source by source:
// whether the filter's covariance and the stated noises are honest. docs/evaluation.md,
// "Innovations".
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>

#include "estimator/measurement.hpp"

namespace odomd::tools {

class InnovationStatistics {
 public:
  /// Takes in the samples that a step has judged; those that are inputs, and so not tested, do not
  /// count.
  void add(std::span<const estimator::Judgement> judgements);

  /// By the name of each source that was tested: "count", "gated", "dimension", "mean_nis" (of
  /// νᵀS⁻¹ν; honest: the dimension) and "inside_95" (the share within χ²₉₅; honest: 0.95).
  [[nodiscard]] nlohmann::ordered_json json() const;

 private:
  struct OfSource {
    std::uint64_t count = 0;
    std::uint64_t gated = 0;
    std::uint64_t inside_95 = 0;
    int dimension = 0;
    double sum = 0.0;
  };
  std::array<OfSource, estimator::source_count> sources_{};
};

}  // namespace odomd::tools
