#include "tools/drive_files/innovation_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "tools/cli/files.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::tools {
namespace {

using estimator::Judgement;

constexpr std::string_view unknown = " is unknown; use a file of odom replay --innovations";
constexpr std::array<std::string_view, 3> axes{"1", "2", "3"};
constexpr std::size_t degrees_column = 3, first_sigma_column = 7;

// The file contains the square roots of the variances.
constexpr auto columns = [](auto&& cell, auto& row) {
  cell("t", row.time_ns);
  cell("source", Word{row.source, estimator::source_names, unknown});
  cell("verdict", Word{row.verdict, estimator::verdict_names, unknown});
  cell("degrees", row.degrees);
  for (std::size_t i = 0; i < 3; ++i) cell("nu_", row.innovation[i], axes[i]);
  for (std::size_t i = 0; i < 3; ++i) cell("sigma_", row.variance[i], axes[i]);
  cell("nis", row.squared_ratio);
};

}  // namespace

std::string innovation_header() {
  return header_of<Judgement>(columns);
}

void append_innovation_rows(std::string& out, const Judgement& judgement) {
  Judgement row = judgement;
  for (double& variance : row.variance) variance = std::sqrt(std::max(variance, 0.0));
  for (std::uint32_t sample = 0; sample < judgement.count; ++sample) append_row(out, columns, row);
}

std::vector<Judgement> read_innovations(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader{input, file.string(), names_of<Judgement>(columns)};
  std::vector<Judgement> judgements;
  while (reader.next()) {
    auto one = read_row<Judgement>(reader, columns);
    if (one.degrees != 0 && one.degrees != 1 && one.degrees != 3)
      reader.fail(degrees_column, "must be 0, 1 or 3");
    for (std::size_t i = 0; i < 3; ++i) {
      if (one.variance[i] < 0.0)
        reader.fail(first_sigma_column + i, "a standard deviation is negative; correct the line");
      one.variance[i] *= one.variance[i];
    }
    judgements.push_back(one);
  }
  if (judgements.empty()) {
    throw std::invalid_argument(file.string() +
                                ": has no rows; only the full filter tests samples");
  }
  return judgements;
}

}  // namespace odomd::tools
