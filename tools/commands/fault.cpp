// odom fault: injects faults of sensors, buses and cameras, into logs and live.
#include <thread>
#include <tuple>

#include "base/wall_clock.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/fault/fault.hpp"
#include "tools/fault/injector.hpp"
#include "tools/fault/live.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

using fault::Fault;

struct FaultOptions {
  std::string config;
  std::string kind;
  std::optional<double> begin_s;
  std::optional<double> duration_s;
  std::optional<double> size;
  std::uint64_t seed = 1;
  std::vector<std::string> faults;
  std::string log;
  std::string out;
  std::string camera;
  std::string camera_out;
  std::string from;
  std::string to;
  std::string camera_from;
  std::string camera_to;
  double wait_s = 0.0;
  bool list = false;
  bool json = false;
  can::Damage damage = can::Damage::left_out;
};

std::vector<Fault> faults_of(const FaultOptions& options) {
  std::vector<Fault> faults;
  if (!options.kind.empty()) {
    Fault one = fault::fault_of(fault::parse_kind(options.kind));
    if (options.begin_s) one.begin_s = *options.begin_s;
    if (options.duration_s) one.duration_s = *options.duration_s;
    if (options.size) one.magnitude = *options.size;
    check(one);
    faults.push_back(one);
  }
  for (const std::string& text : options.faults) faults.push_back(fault::parse_fault(text));
  if (faults.empty()) require("--kind (or --fault)");
  for (Fault& one : faults) one.seed = options.seed;
  return faults;
}

bool is_live(const FaultOptions& options) {
  return !options.from.empty() || !options.camera_from.empty();
}

void check_streams(const FaultOptions& options, const std::vector<Fault>& faults) {
  // Both options are required, or neither.
  for (const auto& [one, name, other, other_name] :
       {std::tuple{options.log, "LOG", options.out, "--out"},
        {options.camera, "--camera", options.camera_out, "--camera-out"},
        {options.from, "--from", options.to, "--to"},
        {options.camera_from, "--camera-from", options.camera_to, "--camera-to"}})
    if (one.empty() != other.empty())
      require(one.empty() ? fmt::format("{} (for {})", name, other_name)
                          : fmt::format("{} (for {})", other_name, name));
  const bool live = is_live(options);
  const bool logs = !options.log.empty() || !options.camera.empty();
  if (!logs && !live) require("LOG (or --camera, --from, --camera-from)");
  if (logs && live)
    throw std::invalid_argument(
        "give either logs (LOG, --camera) or live inputs (--from, --camera-from), not both");
  const bool frames = !options.log.empty() || !options.from.empty();
  const bool poses = !options.camera.empty() || !options.camera_from.empty();
  for (const Fault& one : faults) {
    const bool of_camera = one.kind.part == fault::Part::camera;
    const std::string name = name_of(one.kind);
    if (of_camera && !poses)
      require("--camera and --camera-out (or --camera-from and --camera-to), for " + name);
    if (one.kind.act == fault::Act::shifted && live)
      throw std::invalid_argument(fmt::format("{}: the receiver stamps live frames; use {}.delayed",
                                              name, info(one.kind.part).name));
    if (!of_camera && !frames) require("LOG and --out (or --from and --to), for " + name);
  }
}

// Prints how many frames or poses came in and went out, and how many of them each fault changed.
// Warns of faults that had no effect, which is rarely intended.
void report(const std::string& input, std::uint64_t in, std::uint64_t out,
            const std::vector<fault::Acted>& acted, const char* what) {
  std::cerr << fmt::format("odom fault: {}{} {} in, {} out\n", input, in, what, out);
  for (const auto& [one, count] : acted) {
    const std::string name = name_of(one.kind);
    if (count == 0)
      warn("fault", fmt::format("{}: had no effect; it begins {:g} s after the first frame", name,
                                one.begin_s));
    else
      std::cerr << fmt::format("odom fault: {}: {} {}\n", name, count, what);
  }
}

struct ConfiguredCar {
  daemon::Config config;
  std::vector<can::Database> databases;
};

ConfiguredCar car_of(const FaultOptions& options) {
  if (options.config.empty()) require("--config");
  ConfiguredCar car{.config = daemon::load_config(options.config)};
  diagnostics::Diagnostics warnings;
  car.databases = daemon::load_databases(car.config, warnings);
  return car;
}

void check_files(const FaultOptions& options, const ConfiguredCar& car) {
  std::vector<std::filesystem::path> inputs = car.config.can.dbc;
  for (const std::string& input : {options.config, options.camera})
    if (!input.empty()) inputs.emplace_back(input);
  if (!options.log.empty()) inputs.emplace_back(options.log == "-" ? "/dev/stdin" : options.log);
  check_outputs(std::vector<Output>{{"--out", options.out}, {"--camera-out", options.camera_out}},
                inputs);
}

// Returns the time that the faults count from: the log's first stamp.
std::int64_t fail_in_log(const FaultOptions& options, const ConfiguredCar& car,
                         const std::vector<Fault>& faults) {
  can::BusNames buses;
  for (const std::string& bus : daemon::expected_buses(car.config)) buses.index_of(bus);
  can::LogReader log(options.log, buses, options.damage);
  fault::Injector injector(car.config, car.databases, buses.all(), faults);
  WholeFile sink(options.out);
  ProgressLine progress("odom fault");
  const auto flush = options.log == "-" ? fault::Flush::every_frame : fault::Flush::at_the_end;
  const fault::Streamed streamed = write_log(log, buses, injector, sink.stream(), flush,
                                             [&](const std::string& text) { progress.show(text); });
  sink.finish();
  progress.end();
  for (const std::string& warning : log.warnings()) warn("fault", warning);
  report(log.label() + ": ", streamed.in, streamed.out, injector.acted(), "frames");
  return streamed.first_ns;
}

void fail_in_camera_log(const FaultOptions& options, const CameraLog& camera,
                        const std::vector<Fault>& faults, std::int64_t start_ns) {
  fault::CameraInjector injector(faults, start_ns);
  WholeFile sink(options.camera_out);
  const fault::Streamed streamed = write_camera_log(camera.poses, injector, sink.stream());
  sink.finish();
  report(options.camera + ": ", streamed.in, streamed.out, injector.acted(), "camera poses");
}

void fail_in_logs(const FaultOptions& options, const std::vector<Fault>& faults) {
  const ConfiguredCar car = options.log.empty() ? ConfiguredCar{} : car_of(options);
  check_files(options, car);
  CameraLog camera;
  std::int64_t start_ns = 0;
  // Read before the log is written: nothing is written if either input cannot be used.
  if (!options.camera.empty()) {
    camera = read_camera_log(options.camera);
    warn("fault", camera.warnings);
    if (camera.poses.empty())
      warn("fault", {no_camera_pose(options.camera)});
    else
      start_ns = camera.poses.front().arrival_ns;
  }
  if (!options.log.empty()) start_ns = fail_in_log(options, car, faults);
  if (!options.camera.empty()) fail_in_camera_log(options, camera, faults, start_ns);
}

void fail_live(const FaultOptions& options, const std::vector<Fault>& faults) {
  constexpr std::chrono::microseconds between{500};
  Interrupt interrupt;
  const std::int64_t start_ns = monotonic_now();
  std::optional<fault::BusRelay> bus;
  std::optional<fault::CameraRelay> camera;
  if (!options.from.empty()) {
    const ConfiguredCar car = car_of(options);
    bus.emplace(options.from, options.to, car.config, car.databases, faults, start_ns);
  }
  if (!options.camera_from.empty())
    camera.emplace(options.camera_from, options.camera_to, options.wait_s, faults, start_ns);
  std::cerr << "odom fault: handing on";
  if (bus) std::cerr << fmt::format(" {} to {}", options.from, options.to);
  if (camera)
    std::cerr << fmt::format("{} {} to {}", bus ? "," : "", options.camera_from, options.camera_to);
  std::cerr << "; INT ends it\n";
  while (!interrupt.requested()) {
    const std::int64_t now_ns = monotonic_now();
    if (bus) bus->pass_on(now_ns);
    if (camera) camera->pass_on(now_ns);
    std::this_thread::sleep_for(between);
  }
  if (bus) {
    report("", bus->relayed().received, bus->relayed().sent, bus->acted(), "frames");
    if (bus->lost() > 0)
      warn("fault", fmt::format("the kernel dropped {} frames before they were read", bus->lost()));
  }
  if (camera) {
    const fault::Relayed& relayed = camera->relayed();
    report("", relayed.received, relayed.sent, camera->acted(), "camera poses");
    if (relayed.refused > 0)
      warn("fault", fmt::format("{} poses found no daemon", relayed.refused));
    if (relayed.malformed > 0)
      warn("fault", fmt::format("{} messages were not camera poses; left out", relayed.malformed));
  }
}

void run(const FaultOptions& options) {
  if (options.list) {
    std::cout << (options.json ? fault::kinds_json().dump(1) + '\n' : fault::kinds_text());
    return;
  }
  const std::vector<Fault> faults = faults_of(options);
  check_streams(options, faults);
  (is_live(options) ? fail_live : fail_in_logs)(options, faults);
}

}  // namespace

void add_fault(Command odom) {
  auto options = std::make_shared<FaultOptions>();
  Command command = odom.add_subcommand(
      "fault", "Inject faults of sensors, the bus or the camera, into logs or live");
  command.add("LOG", "", options->log, "Log of candump -L, or - for standard input");
  command.add_flag("--list", options->list, "List the kinds of faults and their default sizes");
  command.add("--config", "FILE", options->config, "Configuration of the car (TOML)");
  command.add("--kind", "KIND", options->kind, "Kind of the fault, such as gyro.frozen");
  command.add("--begin", "S", options->begin_s,
              "Start of the fault after the first frame [s]; default: 0",
              {not_negative(), needs("--kind")});
  command.add("--for", "S", options->duration_s, "Duration of the fault [s]; default: to the end",
              {positive(), needs("--kind")});
  command.add("--size", "X", options->size,
              "Size of the fault, in the unit that --list shows; default: see --list",
              {needs("--kind")});
  command.add("--fault", "KIND:BEGIN:LENGTH:SIZE", options->faults,
              "Kind, begin, duration and size as one argument; omitted or empty fields take the "
              "defaults above; repeatable",
              {one_each()});
  command.add("--seed", "N", options->seed, "Seed of random faults; default: 1");
  command.add("-o,--out", "LOG", options->out, "Log to write, or - for standard output");
  command.add("--camera", "CSV", options->camera, "Camera log");
  command.add("--camera-out", "CSV", options->camera_out, "Camera log to write");
  const Command live = command.group("Live");
  live.add("--from", "IFACE", options->from, "CAN interface to read frames from");
  live.add("--to", "IFACE", options->to, "CAN interface to send the frames to");
  live.add("--camera-from", "PATH", options->camera_from,
           "Socket to create, to which the camera sends its poses");
  live.add("--camera-to", "PATH", options->camera_to, "Camera socket of the daemon");
  add_wait_option(live, options->wait_s);
  command.add_flag("--json", options->json, "Print the list as JSON", {needs("--list")});
  add_strict(command, options->damage);
  command.footer(
      "Examples:\n"
      "  odom fault --list\n"
      "  odom fault --config car.toml --kind gyro.frozen --begin 10 --for 5 drive.log -o "
      "faulty.log\n"
      "  odom fault --config car.toml --fault wheels.scaled:20::1.1 --fault camera.lost:30:5 \\\n"
      "      drive.log -o faulty.log --camera camera.csv --camera-out faulty.csv\n"
      "  odom sim --config-only --out drive\n"
      "  odom sim --live --out drive --force |\n"
      "      odom fault --config drive/car.toml --kind imu.lost --begin 20 - -o - |\n"
      "      odomd --config drive/car.toml --can - --exit-at-end\n"
      "  odom fault --config car.toml --kind steering.biased --from can0 --to vcan0\n"
      "Only the bits of the failing signals are changed; counters and checksums are recomputed.\n"
      "Times count from the first frame of the log, or from the start if live. INT ends a live\n"
      "run.");
  command.callback([options] { run(*options); });
}

}  // namespace odomd::tools
