// Runs odom import on tables that a test writes.
#pragma once

#include "tests/tools/scratch.hpp"

namespace odomd::tools {

struct TextFile {
  std::string name, text;
};

inline constexpr const char* a_car = " --mass 3 --wheelbase 0.26 --track 0.16 ";

/// Imports into "out" in the scratch directory, which is the working directory.
inline Outcome import(const Scratch& scratch, const std::vector<TextFile>& files,
                      const std::string& options) {
  std::string tables;
  for (const TextFile& file : files) {
    scratch.write(file.name, file.text);
    if (file.name.ends_with(".csv")) tables += ' ' + file.name;
  }
  return scratch.run("odom import" + tables + " --out out " + options);
}

/// A moving car, 10 rows a second: `header` begins with "t,v"; `more`: further cells of each row.
inline std::string rows_of(const std::string& header, double t0, const std::string& more = "") {
  std::string text = header + '\n';
  for (int i = 0; i < 5; ++i)
    text += std::to_string(t0 + 0.1 * i) + ",1." + std::to_string(i) + more + '\n';
  return text;
}

}  // namespace odomd::tools
