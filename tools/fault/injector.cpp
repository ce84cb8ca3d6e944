#include "tools/fault/injector.hpp"

#include <algorithm>
#include <stdexcept>

#include "daemon/core/config_error.hpp"

namespace odomd::fault {
namespace {

std::array<double, estimator::source_count> stated_sigma(const daemon::Config& config) {
  std::array<double, estimator::source_count> sigma{};
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    const double stated = config.can.signals[i].sigma;
    sigma[i] = stated > 0.0 ? stated : estimator::default_sigma[i];
  }
  return sigma;
}

}  // namespace

void require_mapped(const daemon::Config& config, std::span<const Fault> faults) {
  for (const Fault& fault : faults) {
    const Part part = fault.kind.part;
    if (part == Part::bus || part == Part::camera) continue;
    const Sources sources = sources_of(fault.kind);
    const bool mapped = std::ranges::any_of(config.can.bindings, [&](const auto& binding) {
      return contains(sources, static_cast<estimator::Source>(binding.channel));
    });
    if (mapped) continue;
    std::string keys;
    for (std::size_t i = 0; i < estimator::source_count; ++i)
      if (contains(sources, static_cast<estimator::Source>(i)))
        keys += (keys.empty() ? "" : ", ") + std::string(estimator::source_names[i]);
    throw std::invalid_argument(config.file.string() + ": [can.signals] maps no " + keys +
                                ", which " + name_of(fault.kind) + " needs; map it there");
  }
}

Injector::Injector(const daemon::Config& config, std::span<const can::Database> databases,
                   std::span<const std::string> bus_names, std::span<const Fault> faults)
    : signals_(config.can, databases, bus_names), sigma_(stated_sigma(config)) {
  require_mapped(config, faults);
  std::ranges::copy_if(faults, std::back_inserter(faults_),
                       [](const Fault& fault) { return fault.kind.part != Part::camera; });
}

void Injector::start(std::int64_t start_ns) {
  stages_.clear();
  for (const Fault& fault : faults_)
    stages_.emplace_back(signals_, sigma_, fault, span_of(fault, start_ns));
  started_ = true;
}

// Passes the contents of in_ through all stages from the given one on.
void Injector::pass(std::size_t stage, std::vector<can::Frame>& out) {
  for (; stage < stages_.size(); ++stage) {
    next_.clear();
    for (const can::Frame& frame : in_) stages_[stage].take(frame, next_);
    in_.swap(next_);
  }
  out.insert(out.end(), in_.begin(), in_.end());
}

void Injector::take(const can::Frame& frame, std::vector<can::Frame>& out) {
  if (!started_) start(frame.time_ns);
  in_.assign(1, frame);
  pass(0, out);
}

void Injector::release(std::int64_t now_ns, std::vector<can::Frame>& out) {
  for (std::size_t stage = 0; stage < stages_.size(); ++stage) {
    in_.clear();
    stages_[stage].release(now_ns, in_);
    pass(stage + 1, out);
  }
}

std::vector<Injector::Acted> Injector::acted() const {
  std::vector<Acted> result;
  for (std::size_t i = 0; i < faults_.size(); ++i)
    result.push_back({faults_[i], started_ ? stages_[i].acted_on() : 0});
  return result;
}

}  // namespace odomd::fault
