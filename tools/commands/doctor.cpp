// odom doctor: finds faults of the machine, the daemon, the buses or a drive, and how to fix them.
#include "tools/doctor/doctor.hpp"
#include "can_protocol/sources/open_source.hpp"
#include "daemon/core/config.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/status_value.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostics;

struct DoctorOptions {
  std::string socket;
  std::filesystem::path config;
  std::filesystem::path drive;
  std::vector<std::string> interfaces;
  int listen_s = 30;
  bool json = false;
  can::Damage damage = can::Damage::left_out;
};

// A part of the system, examined or not.
struct Part {
  std::string name;  ///< "machine", "bus can0"
  std::string note;  ///< why it was not examined, or which of its checks were left out
  Diagnostics diagnostics;
  bool examined = true;
};

struct Examination {
  std::vector<Part> parts;
  std::vector<doctor::Identifier> identifiers;  ///< of the received frames

  void add(const std::string& name, Diagnostics diagnostics, const std::string& note = {}) {
    parts.push_back({name, note, std::move(diagnostics)});
  }
  void add(const std::string& name, doctor::DriveExamination drive) {
    add(name, std::move(drive.diagnostics), drive.note);
  }
  [[nodiscard]] std::size_t count() const {
    std::size_t all = 0;
    for (const Part& part : parts) all += part.diagnostics.size();
    return all;
  }
};

std::string as_text(const Examination& examination) {
  std::string text;
  for (const Part& part : examination.parts) {
    if (part.diagnostics.empty()) {
      text += fmt::format("{}: {}{}{}\n", part.name, part.examined ? "fine" : "",
                          part.examined && !part.note.empty() ? "; " : "", part.note);
      continue;
    }
    text += part.name + (part.note.empty() ? ":\n" : ": " + part.note + '\n');
    for (const diagnostics::Diagnostic& one : part.diagnostics) {
      text += fmt::format("  {}{}{} [{}]\n", one.subject, one.subject.empty() ? "" : ": ", one.seen,
                          one.kind->code);
      if (const std::string fix = fix_of(one); !fix.empty()) text += "    fix: " + fix + '\n';
    }
  }
  if (!examination.identifiers.empty()) {
    Table table{{"bus", "id", "frames", "1/s", "message"}, {}, {0, 1, 4}};
    for (const doctor::Identifier& one : examination.identifiers)
      table.rows.push_back({one.bus, fmt::format("{:03X}", one.id), std::to_string(one.frames),
                            fixed(one.rate_hz, 1),
                            one.message.empty() ? "not mapped" : one.message});
    text += '\n' + table.text() + '\n';
  }
  const std::size_t count = examination.count();
  return text + (count == 0 ? "nothing found\n" : counted(count, "finding") + '\n');
}

std::string json_of(const Examination& examination) {
  nlohmann::ordered_json json{{"findings", examination.count()},
                              {"parts", nlohmann::ordered_json::array()}};
  for (const Part& part : examination.parts)
    json["parts"].push_back({{"name", part.name},
                             {"examined", part.examined},
                             {"note", part.note},
                             {"diagnostics", as_json(part.diagnostics)}});
  for (const doctor::Identifier& one : examination.identifiers)
    json["identifiers"].push_back({{"bus", one.bus},
                                   {"id", one.id},
                                   {"extended", one.format == can::IdFormat::extended},
                                   {"frames", one.frames},
                                   {"rate_hz", one.rate_hz},
                                   {"message", one.message}});
  return json_text(json, 2) + '\n';
}

// The status of the daemon; nothing if it cannot be read, with the reason in `why`.
std::optional<Json> read_status(const DoctorOptions& options, std::string& why) {
  try {
    const std::string path = socket_path(options.socket, "status.sock");
    return parse_status(fetch_status(path), path);
  } catch (const NobodyThere& error) {
    why = error.what();
  } catch (const std::runtime_error& error) {
    if (!options.socket.empty()) throw std::invalid_argument(error.what());
    why = fmt::format("not examined: {}", error.what());
  }
  return std::nullopt;
}

void examine_here(const DoctorOptions& options, Examination& examination) {
  doctor::Needs needs;
  std::vector<std::string> buses;
  can::FrameProtocol protocol = can::FrameProtocol::classic;
  Diagnostics configured;
  if (!options.config.empty()) {
    daemon::Config config = daemon::load_config(options.config);
    configured = config.warnings;
    const auto databases = daemon::load_databases(config, configured);
    needs.priority = config.realtime.priority;
    needs.receive_buffer = config.can.receive_buffer;
    buses = config.can.sources;
    protocol = doctor::needed_protocol(config, databases);
  }
  std::string why;
  const std::optional<Json> status = read_status(options, why);
  needs.is_granted = status.has_value();
  const doctor::Machine machine = doctor::read_machine();
  examination.add("machine", examine_machine(machine, needs));
  if (status) {
    try {
      examination.add("odomd", doctor::examine_daemon(*status, machine));
      if (options.config.empty())
        for (const StatusValue& bus : StatusValue{*status}["can"].elements())
          buses.push_back(bus["name"].text());
    } catch (const nlohmann::json::exception& error) {
      throw std::runtime_error(
          fmt::format("the status of odomd {} cannot be read by odom {}: "
                      "install both from one build ({})",
                      status->value("version", "?"), ODOMD_VERSION, error.what()));
    }
  } else {
    examination.parts.push_back({"odomd", why, {}, false});
  }
  if (!options.config.empty())
    examination.add(options.config.string(), std::move(configured),
                    doctor::guesses_in(options.config));
  for (const std::string& bus : buses)
    if (can::source_kind(bus) == can::SourceKind::interface)
      examination.add("bus " + bus, examine_link(bus, doctor::read_link(bus), protocol));
}

void examine_buses(const DoctorOptions& options, Examination& examination) {
  Drive heard;
  heard.config = daemon::load_config(options.config);
  heard.databases = daemon::load_databases(heard.config, heard.warnings);
  const auto protocol = doctor::needed_protocol(heard.config, heard.databases);
  bool up = true;
  std::vector<doctor::Link> links;
  for (const std::string& bus : options.interfaces) {
    const auto link = doctor::read_link(bus);
    examination.add("bus " + bus, doctor::examine_link(bus, link, protocol));
    up &= link && link->is_can && link->is_up;
    links.push_back(link.value_or(doctor::Link{}));
  }
  if (!up) return;  // no frame would come
  doctor::listen(heard, options.interfaces, std::chrono::seconds{options.listen_s});
  for (std::size_t i = 0; i < links.size(); ++i)
    append(examination.parts.at(i).diagnostics,
           doctor::examine_acknowledgement(options.interfaces.at(i), links[i], heard));
  examination.identifiers = doctor::identifiers_of(heard);
  examination.add(fmt::format("frames of {} s", options.listen_s), doctor::examine_drive(heard));
}

void run_doctor(const DoctorOptions& options) {
  Examination examination;
  if (!options.drive.empty()) {
    examination.add(options.drive.string(),
                    doctor::examine_drive(read_drive({.folder = options.drive,
                                                      .config = options.config,
                                                      .reference = {},
                                                      .damage = options.damage})));
  } else if (!options.interfaces.empty()) {
    examine_buses(options, examination);
  } else {
    examine_here(options, examination);
  }
  std::cout << (options.json ? json_of(examination) : as_text(examination));
  if (examination.count() > 0) throw Ended(exit_failed);
}

}  // namespace

void add_doctor(Command odom) {
  Command command = odom.add_subcommand(
      "doctor", "Find problems of the machine, the daemon, a bus or a drive, and how to fix them");
  const auto options = std::make_shared<DoctorOptions>();
  command.add("--config", "TOML", options->config,
              "Configuration of the car (TOML) to check, together with its buses; with --drive, it "
              "replaces the drive's car.toml");
  command.add("--drive,DIR", "DIR", options->drive,
              "Examine only this drive, a folder of odom record or odom sim");
  command.add("--can", "IFACE", options->interfaces,
              "Examine only this CAN interface and the frames received on it; repeatable",
              {repeatable(), needs("--config"), excludes("--drive")});
  constexpr int longest_s = 600;
  command.add("--for", "S", options->listen_s,
              "Time to listen [s], while somebody drives the car; default: 30",
              {within(1, longest_s), needs("--can")});
  add_socket_option(command, options->socket, "status", {excludes("--drive"), excludes("--can")});
  command.add_flag("--json", options->json, "Print the result as JSON");
  add_strict(command, options->damage);
  command.footer(
      "Examples:\n"
      "  odom doctor                                    # this machine, and odomd if it runs\n"
      "  odom doctor --config /etc/odomd/can0.toml      # and the configuration with its buses\n"
      "  odom doctor --can can0 --for 30 --config car.toml   # drive some turns meanwhile\n"
      "  odom doctor --drive drive-20261121-140300\n"
      "Each finding has a fix and a code, which docs/diagnostics.md explains. A fix that\n"
      "writes nothing under /etc lasts only until the next reboot.\n"
      "Exit status: 0 nothing found, 1 findings, 2 wrong usage or unusable input.");
  command.callback([options] { run_doctor(*options); });
}

}  // namespace odomd::tools
