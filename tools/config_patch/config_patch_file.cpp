// Patches a configuration file completely or not at all.
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/files.hpp"
#include "tools/config_patch/config_patch.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  // Checked before reading: a pipe might never end.
  std::error_code error;
  if (fs::exists(file, error) && !fs::is_regular_file(file, error) &&
      !fs::is_directory(file, error))
    throw std::invalid_argument(file.string() + ": is not a regular file; it cannot be patched");
  if (!fs::exists(file, error))
    throw std::invalid_argument(file.string() +
                                ": there is no such file; --write changes an existing "
                                "configuration: copy the car's there first");
  std::string text = daemon::read_toml_file(file);
  // In a writable folder even a write-protected file could be replaced.
  if (::access(file.c_str(), W_OK) != 0 && errno == EACCES) {
    struct stat status {};
    const bool own = ::stat(file.c_str(), &status) == 0 && status.st_uid == ::geteuid();
    throw std::invalid_argument(
        file.string() + (own ? ": is write-protected; allow it with chmod u+w"
                             : ": belongs to another user; use sudo, or --write to a copy"));
  }
  return text;
}

}  // namespace

std::optional<ConfigValue> value_in(const std::filesystem::path& file, const std::string& key) {
  return value_in(daemon::read_toml_file(file), file, key);
}

daemon::Config config_with(const daemon::Config& config, std::span<const ConfigValue> values) {
  daemon::Config result =
      daemon::parse_config(patched(config.text, config.file, values), config.file);
  result.can.sources = config.can.sources;
  result.can.dbc = config.can.dbc;
  diagnostics::Diagnostics ignored;  // were reported when the configuration was loaded
  (void)daemon::load_databases(result, ignored);
  return result;
}

void check_patchable(const std::filesystem::path& file) {
  (void)daemon::parse_toml(text_of(file), file);
  check_writable(file);
}

void patch_config(const std::filesystem::path& file, std::span<const ConfigValue> values) {
  const std::string before = text_of(file);
  const std::string after = patched(before, file, values);
  WholeFile copy(file);
  copy.stream() << after;
  try {
    (void)daemon::parse_config(after, file);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{} (nothing was written)", error.what()));
  }
  if (after != before) copy.finish();
}

}  // namespace odomd::tools
