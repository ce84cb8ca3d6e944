// A configuration file, patched completely or not at all.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include "base/file_descriptor.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/config_patch/config_patch.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

/// A temporary file in the folder of another. It is removed unless it replaced that file.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& place)
      : name_((place.parent_path() / ("." + place.filename().string() + ".XXXXXX")).string()) {
    file_ = FileDescriptor(::mkostemp(name_.data(), O_CLOEXEC));
    if (file_.get() < 0) fail(place, errno);
  }
  ~TemporaryFile() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }

  void write(const std::string& text, const fs::path& place) {
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t count = ::write(file_.get(), text.data() + done, text.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail(place, errno);
      done += static_cast<std::size_t>(count);
    }
    struct stat status {};
    if (::stat(place.c_str(), &status) != 0) fail(place, errno);
    // The file must keep its owner; if that is not possible it must at least remain readable to the
    // same users.
    if (::fchown(file_.get(), status.st_uid, status.st_gid) != 0 && errno != EPERM)
      fail(place, errno);
    if (::fchmod(file_.get(), status.st_mode & 07777U) != 0 || ::fsync(file_.get()) != 0)
      fail(place, errno);
  }

  void take_the_place_of(const fs::path& place) {
    if (::rename(name_.c_str(), place.c_str()) != 0) fail(place, errno);
    name_.clear();
  }

 private:
  [[noreturn]] static void fail(const fs::path& place, int error) {
    throw std::runtime_error(
        fmt::format("{}: cannot be written: {}", place.string(), std::strerror(error)));
  }

  std::string name_;
  FileDescriptor file_;
};

/// The reason why a text does not load, worded as for `file`.
void check_that_it_loads(const std::string& copy, const fs::path& file) {
  try {
    (void)daemon::load_config(copy);
  } catch (const std::invalid_argument& error) {
    std::string what = error.what();
    for (std::size_t at = what.find(copy); at != std::string::npos; at = what.find(copy))
      what.replace(at, copy.size(), file.string());
    throw std::invalid_argument(what + " (nothing was written)");
  }
}

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
  // It would be replaced, as its folder is writable.
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

std::optional<double> number_in(const std::filesystem::path& file, const std::string& key) {
  const std::optional<ConfigValue> there = value_in(file, key);
  return there ? std::optional(there->value) : std::nullopt;
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
  (void)TemporaryFile(fs::canonical(file));
}

void patch_config(const std::filesystem::path& file, std::span<const ConfigValue> values) {
  const std::string before = text_of(file);
  const std::string after = patched(before, file, values);
  const fs::path place = fs::canonical(file);  // keeps a symbolic link
  TemporaryFile copy(place);
  copy.write(after, place);
  check_that_it_loads(copy.name(), file);
  if (after != before) copy.take_the_place_of(place);
}

}  // namespace odomd::tools
