#include "tools/live/service_path.hpp"

#include <cstdlib>
#include <memory>
#include <new>

#include "shm_api/libodom/service.h"

namespace odomd::tools {

std::string service_path(const std::string& named, const std::string& leaf) {
  if (!named.empty()) return named;
  char* path = nullptr;
  if (odomi_service_path(ODOMI_SERVICE_DIRECTORY, leaf.c_str(), &path) != ODOM_OK)
    throw std::bad_alloc();
  std::string result(path);
  std::free(path);  // NOLINT(cppcoreguidelines-no-malloc): malloc'ed by C
  return result;
}

}  // namespace odomd::tools
