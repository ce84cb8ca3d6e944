// Patches a configuration file completely or not at all.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/file_descriptor.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/config_patch/config_patch.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

/// A temporary file that replace() puts in a file's place, in the same folder; otherwise removed.
class Replacement {
 public:
  explicit Replacement(fs::path place)
      : place_(std::move(place)),
        name_((place_.parent_path() / ("." + place_.filename().string() + ".XXXXXX")).string()) {
    file_ = FileDescriptor(::mkostemp(name_.data(), O_CLOEXEC));
    require(file_.get() >= 0);
  }
  ~Replacement() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;

  void write(std::string_view text) {
    while (!text.empty()) {
      const ssize_t count = ::write(file_.get(), text.data(), text.size());
      require(count >= 0 || errno == EINTR);
      if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
    }
    struct stat status {};
    require(::stat(place_.c_str(), &status) == 0);
    // The file must keep its owner; if that is not possible it must at least remain readable to the
    // same users.
    require(::fchown(file_.get(), status.st_uid, status.st_gid) == 0 || errno == EPERM);
    require(::fchmod(file_.get(), status.st_mode & 07777U) == 0 && ::fsync(file_.get()) == 0);
  }

  void replace() {
    require(::rename(name_.c_str(), place_.c_str()) == 0);
    name_.clear();
  }

 private:
  void require(bool done) const {
    if (!done)
      throw std::runtime_error(
          fmt::format("{}: cannot be written: {}", place_.string(), std::strerror(errno)));
  }

  fs::path place_;
  std::string name_;
  FileDescriptor file_;
};

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
  // In a writable folder, replace() would replace even a write-protected file.
  if (::access(file.c_str(), W_OK) != 0 && errno == EACCES) {
    struct stat status {};
    const bool own = ::stat(file.c_str(), &status) == 0 && status.st_uid == ::geteuid();
    throw std::runtime_error(file.string() +
                             (own ? ": is write-protected; allow it with chmod u+w"
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
  diagnostics::Diagnostics warnings;  // were given when the configuration was loaded
  (void)daemon::load_databases(result, warnings);
  return result;
}

void check_patchable(const std::filesystem::path& file) {
  (void)daemon::parse_toml(text_of(file), file);
  (void)Replacement(fs::canonical(file));
}

void patch_config(const std::filesystem::path& file, std::span<const ConfigValue> values) {
  const std::string before = text_of(file);
  const std::string after = patched(before, file, values);
  Replacement copy(fs::canonical(file));  // keeps a symbolic link
  copy.write(after);
  try {
    (void)daemon::parse_config(after, file);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{} (nothing was written)", error.what()));
  }
  if (after != before) copy.replace();
}

}  // namespace odomd::tools
