// Makes the sensors of one drive fail, one at a time, and prints when the source monitor reports
// the fault: a line of JSON per fault, and one for the drive without faults. Started by
// tests/campaign/faults.py.
//
//   source_faults FOLDER on|off SEED
#include <bit>
#include <cstdio>
#include <exception>
#include <random>
#include <string>

#include <fmt/format.h>

#include "tests/campaign/source_flags.hpp"

namespace odomd::campaign {
namespace {

void print(const std::string& head, const Drive& drive, const std::vector<FlagChange>& changes) {
  std::string flags;
  for (const FlagChange& change : changes)
    flags += fmt::format(R"({}[{:.3f}, "{}", "{}"])", flags.empty() ? "" : ", ",
                         drive.seconds_at(change.tick_ns),
                         estimator::source_names[estimator::index_of(change.source)], change.flag);
  fmt::print("{{{}\"flags\": [{}]}}\n", head, flags);
}

int run(int argc, char** argv) {
  if (argc != 4 || (std::string(argv[2]) != "on" && std::string(argv[2]) != "off")) {
    fmt::print(stderr, "usage: source_faults FOLDER on|off SEED\n");
    return 2;
  }
  const Drive drive = read_drive({.folder = argv[1]});
  const Camera camera = std::string(argv[2]) == "on" ? Camera::on : Camera::off;
  std::mt19937 random(static_cast<unsigned>(std::stoul(argv[3])));
  // The faults begin in the middle half of the drive. The standard fixes the numbers of
  // std::mt19937, but not those of distributions.
  const double share = 0.25 + 0.5 * (static_cast<double>(random()) / 4294967296.0);
  const auto begin = static_cast<std::size_t>(share * static_cast<double>(drive.ticks));
  const FaultyDrive runs(drive, camera, begin);
  print("", drive, flag_changes(drive, runs.healthy()));

  for (const FaultCase& one : fault_cases(drive, drive.begin_s(begin))) {
    const auto sources = fault::sources_of(one.fault.kind);
    if (fault::contains(sources, Source::camera) && camera == Camera::off) continue;
    const auto shown_ns = shown_at(drive, one);
    print(fmt::format(R"("kind": "{}", "source": "{}", "begin": {:.3f}, "shown": {}, )",
                      fault::name_of(one.fault.kind),
                      estimator::source_names[static_cast<std::size_t>(std::countr_zero(sources))],
                      one.fault.begin_s,
                      shown_ns ? fmt::format("{:.3f}", drive.seconds_at(*shown_ns)) : "null"),
          drive, flag_changes(drive, runs.with({&one.fault, 1}), begin + 1, runs.healthy()[begin]));
  }
  return 0;
}

}  // namespace
}  // namespace odomd::campaign

int main(int argc, char** argv) {
  try {
    return odomd::campaign::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "source_faults: {}\n", error.what());
    return 1;
  }
}
