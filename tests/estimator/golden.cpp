#include "golden.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace odomd::estimator::testing {

namespace {

const std::string path = ODOMD_TEST_DATA "/paper_ekf_golden.csv";

GoldenRow row_of(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream fields(line);
  GoldenRow row{};
  fields >> row.steering >> row.accel_x >> row.yaw_rate >> row.speed;
  for (double& value : row.expected) fields >> value;
  if (!fields) throw std::runtime_error(path + ": not a row of ten numbers: " + line);
  return row;
}

}  // namespace

std::vector<GoldenRow> read_golden() {
  std::ifstream file(path);
  std::vector<GoldenRow> rows;
  for (std::string line; std::getline(file, line);)
    if (!line.empty() && line.front() != '#') rows.push_back(row_of(line));
  if (rows.empty()) throw std::runtime_error(path + ": no rows");
  return rows;
}

}  // namespace odomd::estimator::testing
