#include "estimator/filter.hpp"

#include <cstddef>
#include <stdexcept>

#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {

Filter make_filter(Model model, const FilterSettings& settings) {
  require_possible(settings);
  if (static_cast<std::size_t>(model) >= model_names.size()) {
    throw std::invalid_argument("no such model");
  }
  if (model == Model::full) {
    return Filter(std::in_place_type<FullFilter>, settings);
  }
  return BaselineFilter(model, settings);
}

void set_initial_pose(Filter& filter, const Pose2& pose) noexcept {
  std::visit([&](auto& f) { f.set_initial_pose(pose); }, filter);
}

bool resume(Filter& filter, const Estimate& predecessor, double gap_s) noexcept {
  return std::visit([&](auto& f) { return f.resume(predecessor, gap_s); }, filter);
}

std::optional<Verdict> add(Filter& filter, const Measurement& measurement) noexcept {
  return std::visit([&](auto& f) -> std::optional<Verdict> { return f.add(measurement); }, filter);
}

std::optional<Verdict> add(Filter& filter, const CameraPose& pose) noexcept {
  return std::visit([&](auto& f) -> std::optional<Verdict> { return f.add(pose); }, filter);
}

std::span<const Judgement> judgements(const Filter& filter) noexcept {
  const auto* const full = std::get_if<FullFilter>(&filter);
  return full != nullptr ? full->judgements() : std::span<const Judgement>();
}

SourceNoise noise(const Filter& filter, Source source) noexcept {
  const auto* const full = std::get_if<FullFilter>(&filter);
  return full != nullptr ? full->noise(source) : SourceNoise();
}

SourceFlag flag(const Filter& filter, Source source) noexcept {
  return std::visit([&](const auto& f) { return f.flag(source); }, filter);
}

Estimate step(Filter& filter, std::int64_t tick_ns) noexcept {
  return std::visit([&](auto& f) { return f.step(tick_ns); }, filter);
}

}  // namespace odomd::estimator
