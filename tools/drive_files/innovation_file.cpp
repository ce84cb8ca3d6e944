#include "tools/drive_files/innovation_file.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <stdexcept>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

using estimator::Judgement;

enum Column : std::size_t { t, source, verdict, degrees, nu, sigma = nu + 3, nis = sigma + 3 };

const std::vector<std::string> columns{"t",    "source",  "verdict", "degrees", "nu_1", "nu_2",
                                       "nu_3", "sigma_1", "sigma_2", "sigma_3", "nis"};

// The index of a word in a list of words.
template <typename Names>
std::size_t number_of(const CsvReader& reader, std::size_t column, const Names& names) {
  const auto found = std::ranges::find(names, reader.text(column));
  if (found == names.end()) {
    reader.fail(column, quoted(reader.text(column)) +
                            " is unknown; use a file of odom replay --innovations");
  }
  return static_cast<std::size_t>(found - names.begin());
}

void append_row(std::string& out, const Judgement& judgement) {
  append_seconds(out, judgement.time_ns);
  out += ',';
  out += estimator::source_names.at(static_cast<std::size_t>(judgement.source));
  out += ',';
  out += estimator::verdict_names.at(static_cast<std::size_t>(judgement.verdict));
  out += ',' + std::to_string(judgement.degrees);
  const auto number = [&out](double value) {
    out += ',';
    append_number(out, value);
  };
  for (const double value : judgement.innovation) number(value);
  for (const double value : judgement.variance) number(std::sqrt(std::max(value, 0.0)));
  number(judgement.squared_ratio);
  out += '\n';
}

}  // namespace

void write_innovation_header(std::ostream& out) {
  for (std::size_t i = 0; i < columns.size(); ++i) out << (i == 0 ? "" : ",") << columns[i];
  out << '\n';
}

void append_innovation_rows(std::string& out, const Judgement& judgement) {
  for (std::uint32_t sample = 0; sample < judgement.count; ++sample) append_row(out, judgement);
}

std::vector<Judgement> read_innovations(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader{input, file.string(), columns};
  std::vector<Judgement> judgements;
  while (reader.next()) {
    Judgement one;
    one.time_ns = reader.time_ns(t);
    one.source = static_cast<estimator::Source>(number_of(reader, source, estimator::source_names));
    one.verdict =
        static_cast<estimator::Verdict>(number_of(reader, verdict, estimator::verdict_names));
    const double freedom = reader.number(degrees);
    if (freedom != 0.0 && freedom != 1.0 && freedom != 3.0)
      reader.fail(degrees, "must be 0, 1 or 3");
    one.degrees = static_cast<int>(freedom);
    for (std::size_t i = 0; i < 3; ++i) {
      one.innovation[i] = reader.number(nu + i);
      const double root = reader.number(sigma + i);
      if (root < 0.0) reader.fail(sigma + i, "a standard deviation is negative; correct the line");
      one.variance[i] = root * root;
    }
    one.squared_ratio = reader.number(nis);
    judgements.push_back(one);
  }
  if (judgements.empty()) {
    throw std::invalid_argument(file.string() +
                                ": has no rows; only the full filter tests samples");
  }
  return judgements;
}

}  // namespace odomd::tools
