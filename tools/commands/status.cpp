// odom status: shows the daemon's status.
#include <thread>

#include "tools/commands/commands.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/status_value.hpp"
#include "tools/live/watch/page.hpp"

namespace odomd::tools {
namespace {

struct StatusOptions {
  std::string socket;
  bool json = false;
  bool open_metrics = false;
};

// If the daemon does not answer, that is a result, too.
void print_open_metrics(const std::string& named) {
  std::optional<nlohmann::json> status;
  try {
    const std::string socket = socket_path(named, "status.sock");
    status = parse_status(fetch_status(socket), socket);
  } catch (const std::runtime_error& error) {
    warn("status", error.what());
  }
  std::cout << open_metrics(status);
}

void run_status(const StatusOptions& options) {
  const std::string document = fetch_status(options.socket);
  const nlohmann::json first = parse_status(document, options.socket);
  if (options.json) {
    std::cout << document;
    return;
  }
  // Fetch the status twice, so that rates are current, not averages since the start.
  constexpr auto between = std::chrono::milliseconds{500};
  std::this_thread::sleep_for(between);
  const nlohmann::json second = parse_status(fetch_status(options.socket), options.socket);
  try {
    std::cout << watch::status_as_text(second, first);
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(
        options.socket +
        ": the status cannot be parsed; are odom and odomd of the same version? (" + error.what() +
        ")");
  }
}

}  // namespace

void add_status(Command odom) {
  auto options = std::make_shared<StatusOptions>();
  Command command = odom.add_subcommand("status", "Show the daemon's status");
  add_socket_option(command, options->socket, "status");
  command.add_flag("--json", options->json, "Print the daemon's status as JSON");
  command.add_flag("--openmetrics", options->open_metrics,
                   "Print metrics in the OpenMetrics format, for Prometheus", {excludes("--json")});
  command.footer(
      "Examples:\n"
      "  odom status\n"
      "  odom status --json | jq .beat\n"
      "  watch -n 1 odom status\n"
      "  odom status --openmetrics > odom.new && mv odom.new odom.prom   # for node_exporter\n"
      "Without --json and --openmetrics, rates are measured over half a second, so the answer\n"
      "takes that long. With --openmetrics, a daemon that does not answer gives the metric\n"
      "odom_up 0.");
  command.callback([options] {
    if (options->open_metrics) {
      print_open_metrics(options->socket);
      return;
    }
    options->socket = socket_path(options->socket, "status.sock");
    run_status(*options);
  });
}

}  // namespace odomd::tools
