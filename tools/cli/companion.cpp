#include "tools/cli/companion.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace odomd::tools {

void become(const std::string& program, std::vector<std::string> arguments,
            const std::string& where_missing) {
  const auto path = std::filesystem::read_symlink("/proc/self/exe").parent_path() / program;
  arguments.insert(arguments.begin(), path.string());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  ::execv(path.c_str(), argv.data());
  if (errno == ENOENT) throw std::runtime_error(where_missing);
  throw std::runtime_error(path.string() + ": " + std::strerror(errno));
}

}  // namespace odomd::tools
