#include "daemon/options.hpp"

#include <cstdlib>
#include <new>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/sources/open_source.hpp"
#include "daemon/core/usage.hpp"
#include "daemon/sockets/local_socket.hpp"
#include "shm_api/libodom/service.h"
#include "shm_api/segment_file.hpp"

namespace odomd::daemon {
namespace {

/// Puts the name of the option in front of an error about its value.
template <typename Parse>
auto parsed(std::string_view option, Parse parse) {
  try {
    return parse();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
}

/// The directory in which clients look for the sockets of a daemon that is started by hand.
std::filesystem::path socket_directory() {
  char* path = nullptr;
  if (odomi_socket_directory(ODOMI_SERVICE_DIRECTORY, &path) != ODOM_OK) throw std::bad_alloc();
  std::filesystem::path directory(path);
  std::free(path);  // NOLINT(cppcoreguidelines-no-malloc): malloc'ed by C
  return directory;
}

/// Applies the command line's paths and groups: a service sets them independently of the car's
/// file.
void place(const Options& options, Config& config) {
  if (!options.runtime_directory.empty()) {
    const auto directory = std::filesystem::absolute(options.runtime_directory);
    config.shm.name = directory / "pose";
    config.status.path = directory / "status.sock";
    config.camera.socket.path = directory / "camera.sock";
    config.record.path = directory / "record.sock";
  }
  if (!options.shm.empty()) {
    if (options.shm.size() < 2 || options.shm.front() != '/')
      throw std::invalid_argument(
          fmt::format("--shm: \"{}\" must begin with a slash: /odomd, or a path", options.shm));
    config.shm.name = options.shm;
  }
  if (!options.camera_socket.empty()) {
    config.camera.configured = true;
    config.camera.socket.path = std::filesystem::absolute(options.camera_socket);
  }
  if (!options.status_socket.empty())
    config.status.path = std::filesystem::absolute(options.status_socket);
  if (!options.readers.empty()) {
    config.shm.mode = 0640;
    config.shm.group = options.readers;
    config.status.mode = 0660;
    config.status.group = options.readers;
  }
  if (!options.camera_senders.empty()) {
    config.camera.socket.mode = 0660;
    config.camera.socket.group = options.camera_senders;
  }
  place_sockets(config, socket_directory());
}

struct Used {
  std::string by;
  std::filesystem::path path;
};

std::vector<Used> created_files(const Config& config) {
  const std::string segment = shm::segment_path(config.shm.name);
  std::vector<Used> all{
      {"the segment ([shm] name, --shm)", segment},
      {"the lock of the segment", segment + ".lock"},
      {"the unfinished segment", segment + ".tmp"},
      {"the status socket ([status] socket, --status-socket)", config.status.path},
      {"the record socket ([record] socket)", config.record.path}};
  if (config.camera.configured)
    all.push_back(
        {"the camera socket ([camera] socket, --camera-socket)", config.camera.socket.path});
  if (!config.log.file.empty()) all.push_back({"the log ([log] file)", config.log.file});
  return all;
}

/// Each file that the daemon creates must differ in path from all others it creates or reads.
void require_distinct_paths(const Config& config) {
  const auto is_same = [](const std::filesystem::path& lhs, const std::filesystem::path& rhs) {
    std::error_code missing;
    if (std::filesystem::equivalent(lhs, rhs, missing)) return true;
    const auto a = std::filesystem::weakly_canonical(lhs, missing);
    const auto b = std::filesystem::weakly_canonical(rhs, missing);
    // The path is empty if a folder may not be searched.
    return a.empty() || b.empty() ? lhs.lexically_normal() == rhs.lexically_normal() : a == b;
  };
  std::vector<Used> others{{"the configuration", config.file}};
  for (const auto& database : config.can.dbc) others.push_back({"a database", database});
  for (const std::string& source : config.can.sources)
    if (can::source_kind(source) == can::SourceKind::log)
      others.push_back({"a log that is played", source});
  for (const Used& mine : created_files(config)) {
    for (const Used& other : others)
      if (is_same(mine.path, other.path))
        throw std::invalid_argument(fmt::format("{} and {} have one path, {}; name another for one",
                                                other.by, mine.by, mine.path.string()));
    others.push_back(mine);
  }
}

}  // namespace

void add_options(CLI::App& app, Options& options) {
  app.name("odomd");
  app.description(
      "Computes the car's pose from its CAN bus and camera poses, and publishes it in shared "
      "memory.");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.set_version_flag("--version", "odomd " ODOMD_VERSION, "Print the version and exit");
  app.add_option("--config", options.config, "Configuration of the car (TOML)")
      ->type_name("FILE")
      ->required();
  app.add_option("--can", options.sources,
                 "Interface (can0), log of candump -L, or - for a log on standard input; "
                 "repeatable, for several buses; instead of [can] source")
      ->type_name("SRC")
      ->take_all()
      ->allow_extra_args(false);
  struct Text {
    std::string name, type;
    std::string Options::*value;
    std::string help;
  };
  const Text texts[]{
      {"--model", fmt::format("{}", fmt::join(estimator::model_names, "|")), &Options::model,
       "Model of the filter; instead of [filter] model"},
      {"--initial", "X,Y,YAW", &Options::initial,
       "Initial pose [m, m, rad]; instead of [initial] pose"},
      {"--shm", "NAME", &Options::shm, "Segment: a name (/odomd) or a path; instead of [shm] name"},
      {"--camera-socket", "PATH", &Options::camera_socket,
       "Socket for camera processes; instead of [camera] socket"},
      {"--status-socket", "PATH", &Options::status_socket,
       "Socket for odom status; instead of [status] socket"},
      {"--runtime-directory", "DIR", &Options::runtime_directory,
       "Folder of the segment and the sockets: pose, status.sock, camera.sock and record.sock; "
       "instead of the paths in the configuration"},
      {"--readers", "GROUP", &Options::readers,
       "The only group that may read the pose and the status; instead of the permissions and "
       "groups of [shm] and [status]"},
      {"--camera-senders", "GROUP", &Options::camera_senders,
       "The only group that may send camera poses; instead of the mode and group of [camera]"},
  };
  for (const Text& text : texts)
    app.add_option(text.name, options.*text.value, text.help)->type_name(text.type);
  app.add_option("--log-level", options.log_level, "Lowest severity of messages to log")
      ->type_name("trace|debug|info|warn|error|critical|off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "critical", "off"})
                  .description(""));
  app.add_flag("--check", options.check,
               "Check the configuration and the databases, print a summary, and exit");
  app.add_flag("--exit-at-end", options.exit_at_end,
               "Exit when the last log or pipe has ended, instead of continuing by dead reckoning");
  app.footer(std::string(daemon::models_help) +
             "\n\n"
             "Examples:\n"
             "  odomd --config car.toml --check\n"
             "  odomd --config car.toml --can can0\n"
             "  odomd --config car.toml --can drive.log --exit-at-end --initial 0,0,0\n"
             "  candump -L can0 | odomd --config car.toml --can -\n"
             "TERM and INT stop odomd cleanly; HUP reopens the file of [log].\n"
             "Exit status: 0 success, 1 failure while running, 2 wrong usage or unusable input.");
}

Config configure(const Options& options) {
  Config config = load_config(options.config);
  if (!options.sources.empty()) config.can.sources = options.sources;
  if (config.can.sources.size() > can::max_buses)
    throw std::invalid_argument(fmt::format("--can: names {} sources; at most {} are allowed",
                                            config.can.sources.size(), can::max_buses));
  if (const auto twice = named_twice(config.can.sources))
    throw std::invalid_argument(
        fmt::format("--can: names \"{}\" twice; leave one of them out", *twice));
  if (!options.model.empty())
    config.model = parsed("--model", [&] { return parse_model(options.model); });
  if (!options.initial.empty())
    config.initial_pose = parsed("--initial", [&] { return parse_pose(options.initial); });
  place(options, config);
  if (!options.log_level.empty()) config.log.level = options.log_level;
  require_distinct_paths(config);
  return config;
}

void require_groups(const Options& options, const Config& config) {
  const auto require = [&](const std::string& group, bool by_option, std::string_view option,
                           std::string_view key) {
    if (group.empty()) return;
    const std::string named_by =
        by_option ? std::string(option) : fmt::format("{}: {}", config.file.string(), key);
    static_cast<void>(parsed(named_by, [&] { return group_named(group); }));
  };
  require(config.shm.group, !options.readers.empty(), "--readers", "[shm] group");
  if (config.camera.configured)
    require(config.camera.socket.group, !options.camera_senders.empty(), "--camera-senders",
            "[camera] socket_group");
  require(config.status.group, !options.readers.empty(), "--readers", "[status] socket_group");
}

}  // namespace odomd::daemon
