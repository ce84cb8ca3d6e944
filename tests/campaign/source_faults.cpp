// Makes the sensors of one drive fail, one at a time, and prints when the source monitor reports
// the fault: a line of JSON per fault, and one for the drive without faults. Started by
// tests/campaign/faults.py.
//
//   source_faults CONFIG LOG CAMERA|- SEED
#include <cstdio>
#include <exception>
#include <optional>
#include <random>
#include <string>

#include <fmt/format.h>

#include "tests/tools/monitored_drive.hpp"

namespace odomd::tools {
namespace {

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

void print(const std::string& head, const MonitoredDrive& drive,
           const std::vector<FlagChange>& changes) {
  const std::int64_t start_ns = drive.events.front().tick_ns;
  std::string flags;
  for (const FlagChange& change : changes)
    flags += fmt::format(R"({}[{:.3f}, "{}", "{}"])", flags.empty() ? "" : ", ",
                         seconds(change.tick_ns - start_ns),
                         estimator::source_names[static_cast<std::size_t>(change.source)],
                         estimator::source_flag_names[static_cast<std::size_t>(change.flag)]);
  fmt::print("{{{}\"flags\": [{}]}}\n", head, flags);
}

int run(int argc, char** argv) {
  if (argc != 5) {
    fmt::print(stderr, "usage: source_faults CONFIG LOG CAMERA|- SEED\n");
    return 2;
  }
  const MonitoredDrive drive =
      load_drive(daemon::load_config(argv[1]), argv[2], std::string(argv[3]) == "-" ? "" : argv[3]);
  std::mt19937 random(static_cast<unsigned>(std::stoul(argv[4])));
  print("", drive, monitored(drive));

  const std::int64_t start_ns = drive.events.front().tick_ns;
  const std::int64_t end_ns = drive.events.back().tick_ns;
  for (FaultCase one : fault_cases(drive)) {
    // The fault begins in the middle half of the drive. The standard fixes the numbers of
    // std::mt19937, but not those of distributions.
    const double share = 0.25 + 0.5 * (static_cast<double>(random()) / 4294967296.0);
    Fault& fault = one.fault;
    fault.begin_ns = start_ns + std::llround(share * static_cast<double>(end_ns - start_ns));
    const MonitoredDrive failed = with_fault(drive, fault);
    const std::optional<std::int64_t> shown_ns = shown_at(drive, failed, one);
    const std::string shown =
        shown_ns ? fmt::format("{:.3f}", seconds(*shown_ns - start_ns)) : "null";
    print(fmt::format(R"("source": "{}", "kind": "{}", "begin": {:.3f}, "shown": {}, )",
                      estimator::source_names[static_cast<std::size_t>(fault.source)],
                      name_of(fault.kind), seconds(fault.begin_ns - start_ns), shown),
          failed, monitored(failed));
  }
  return 0;
}

}  // namespace
}  // namespace odomd::tools

int main(int argc, char** argv) {
  try {
    return odomd::tools::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "source_faults: {}\n", error.what());
    return 1;
  }
}
