#include "golden.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace odomd::estimator::testing {

std::vector<GoldenRow> read_golden() {
  const std::string path = ODOMD_TEST_DATA "/paper_ekf_golden.csv";
  std::ifstream file(path);
  std::vector<GoldenRow> rows;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    for (char& c : line) {
      c = c == ',' ? ' ' : c;
    }
    std::istringstream fields(line);
    GoldenRow row{};
    fields >> row.steering >> row.accel_x >> row.yaw_rate >> row.speed;
    for (double& value : row.expected) {
      fields >> value;
    }
    if (!fields) {
      throw std::runtime_error(path + ": not a row of ten numbers: " + line);
    }
    rows.push_back(row);
  }
  if (rows.empty()) {
    throw std::runtime_error(path + ": no rows");
  }
  return rows;
}

}  // namespace odomd::estimator::testing
