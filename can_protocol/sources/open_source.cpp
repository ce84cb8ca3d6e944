#include "can_protocol/sources/open_source.hpp"

#include <net/if.h>
#include <sys/stat.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "can_protocol/sources/log_feeder.hpp"

namespace odomd::can {
namespace {

bool is_interface_name(const std::string& name) {
  return !name.empty() && name.size() < IFNAMSIZ && name != "." && name != ".." &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return c > ' ' && c <= '~' && c != '/' && c != ':'; });
}

bool is_file(const std::string& name) {
  struct stat status {};
  return ::stat(name.c_str(), &status) == 0 && !S_ISDIR(status.st_mode);
}

}  // namespace

SourceKind source_kind(const std::string& name) {
  if (name == "-") return SourceKind::standard_input;
  if (name.find('/') != std::string::npos || name.ends_with(".log")) return SourceKind::log;
  const bool possible = is_interface_name(name);
  if (is_file(name) && !(possible && ::if_nametoindex(name.c_str()) != 0)) return SourceKind::log;
  if (!possible)
    throw std::invalid_argument(
        "\"" + name +
        "\": no such file, and no interface can be called so; name an interface (can0), a candump "
        "log (drive.log), or - for standard input");
  return SourceKind::interface;
}

std::unique_ptr<FrameSource> open_source(const std::string& name, BusNames& buses, LogClock& clock,
                                         SocketCanSettings settings,
                                         const FrameSelection& selected) {
  if (source_kind(name) != SourceKind::interface)
    return std::make_unique<LogFeeder>(name, buses, clock, selected);
  const auto bus = buses.index_of(name);
  if (!bus)
    throw std::invalid_argument(name + ": one bus too many; odomd reads at most " +
                                std::to_string(max_buses));
  settings.bus = *bus;
  return std::make_unique<SocketCanSource>(name, std::move(settings));
}

}  // namespace odomd::can
