#include "tools/innovation_statistics.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace odomd::tools {
namespace {

// χ²₉₅ of one, two and three degrees of freedom.
constexpr std::array<double, 3> chi_squared_95{3.841, 5.991, 7.815};

}  // namespace

void InnovationStatistics::add(std::span<const estimator::Judgement> judgements) {
  for (const estimator::Judgement& judgement : judgements) {
    const auto degrees = static_cast<std::size_t>(judgement.degrees);
    if (degrees < 1 || degrees > chi_squared_95.size()) continue;
    OfSource& source = sources_[static_cast<std::size_t>(judgement.source)];
    source.dimension = judgement.degrees;
    source.sum += judgement.squared_ratio;
    ++source.count;
    if (judgement.verdict == estimator::Verdict::gated) ++source.gated;
    if (judgement.squared_ratio <= chi_squared_95[degrees - 1]) ++source.inside_95;
  }
}

nlohmann::ordered_json InnovationStatistics::json() const {
  auto json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const OfSource& source = sources_[i];
    if (source.count == 0) continue;
    const auto count = static_cast<double>(source.count);
    json[std::string{estimator::source_names[i]}] = {
        {"count", source.count},
        {"gated", source.gated},
        {"dimension", source.dimension},
        {"mean_nis", source.sum / count},
        {"inside_95", static_cast<double>(source.inside_95) / count},
    };
  }
  return json;
}

}  // namespace odomd::tools
