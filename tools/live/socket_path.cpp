#include "tools/live/socket_path.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <memory>
#include <new>

#include "shm_api/libodom/service.h"

namespace odomd::tools {
namespace {

constexpr const char* service = ODOMI_SERVICE_DIRECTORY;

/// Where socket_path() looks, in its order.
std::string places_of(const std::string& leaf) {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const std::string own = runtime != nullptr && *runtime == '/'
                              ? std::string{runtime} + "/odomd/" + leaf
                              : "$XDG_RUNTIME_DIR (not set)";
  return own + ", " + service + "/*/" + leaf + ", " + service + "/" + leaf;
}

}  // namespace

std::string socket_path(const std::string& named, const std::string& leaf) {
  if (!named.empty()) return named;
  char* found = nullptr;
  if (odomi_socket_path(service, leaf.c_str(), &found) != ODOM_OK) throw std::bad_alloc();
  std::string path(found);
  std::free(found);  // NOLINT(cppcoreguidelines-no-malloc): malloc'ed by C
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 && errno == ENOENT)
    throw NobodyThere(places_of(leaf) + ": no such socket; is odomd running" +
                      (leaf == "camera.sock" ? ", with a [camera] table" : "") +
                      "? --socket names another path");
  return path;
}

}  // namespace odomd::tools
