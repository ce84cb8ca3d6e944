// odomd: reads the car's CAN bus and publishes the car's pose in shared memory every 5 ms.
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "base/printable.hpp"
#include "daemon/core/usage.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "daemon/options.hpp"
#include "daemon/run.hpp"

namespace odomd::daemon {
namespace {

constexpr int done = 0;
constexpr int failed = 1;
constexpr int unusable = 2;

int report(const std::string& text, int status) {
  std::cerr << one_line("odomd: " + text) << '\n';
  return status;
}

void start(const Options& options) {
  Config config = configure(options);
  diagnostics::Diagnostics warnings = config.warnings;
  const auto databases = load_databases(config, warnings);
  require_groups(options, config);
  if (options.check) {
    std::cout << escaped(summary(config, databases, warnings), LineBreaks::kept);
    return;
  }
  run_daemon(config, databases, warnings,
             {options.exit_at_end ? AtEnd::exit : AtEnd::go_on,
              options.initial.empty() ? Resume::allowed : Resume::forbidden});
}

int run_command_line(int argc, char** argv) {
  CLI::App app;
  Options options;
  try {
    add_options(app, options);
    refuse_empty_values(app);
    app.parse(argc, argv);
    start(options);
    return std::cout.flush() ? done : report("standard output: cannot be written", failed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(error);
    const Mistake mistake = mistake_in(app, error);
    return report(fmt::format("{}; see {} --help", mistake.what, mistake.command), unusable);
  } catch (const std::invalid_argument& error) {
    return report(error.what(), unusable);
  } catch (const std::exception& error) {
    return report(error.what(), failed);
  }
}

}  // namespace
}  // namespace odomd::daemon

int main(int argc, char** argv) {
  return odomd::daemon::run_command_line(argc, argv);
}
