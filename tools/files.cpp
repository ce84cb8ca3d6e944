#include "tools/files.hpp"

#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

namespace odomd::tools {
namespace {

std::string reason() {
  if (errno == ENOENT) return "no such file or directory; check the path";
  return std::generic_category().message(errno);
}

}  // namespace

std::ifstream open_input(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw std::invalid_argument(file.string() + ": is a directory; name a file");
  }
  errno = 0;
  std::ifstream input{file, std::ios::binary};
  if (!input) throw std::invalid_argument(file.string() + ": " + reason());
  return input;
}

std::ofstream open_output(const std::filesystem::path& file) {
  errno = 0;
  std::ofstream output{file, std::ios::binary};
  if (!output) throw std::invalid_argument(file.string() + ": cannot be written: " + reason());
  return output;
}

void close_output(std::ofstream& output, const std::filesystem::path& file) {
  errno = 0;
  output.close();
  if (!output) throw std::runtime_error(file.string() + ": cannot be written: " + reason());
}

}  // namespace odomd::tools
