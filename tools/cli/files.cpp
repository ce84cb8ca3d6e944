#include "tools/cli/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "base/input_file.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {
namespace {

std::string reason() {
  if (errno == ENOENT) return "no such file or directory; check the path";
  return why_not_written(errno);
}

// The reason why a file cannot be written, from errno.
std::string reason_at(const std::filesystem::path& file) {
  const int error = errno;
  const std::filesystem::path folder = file.parent_path();
  std::error_code ignored;
  if (error == ENOENT && !folder.empty() && !std::filesystem::exists(folder, ignored))
    return "there is no folder " + folder.string() + "; create it, or check the path";
  errno = error;
  return reason();
}

}  // namespace

std::ifstream open_input(const std::filesystem::path& file) {
  if (const std::string problem = problem_with_input(file); !problem.empty())
    throw std::invalid_argument(file.string() + ": " + problem);
  errno = 0;
  std::ifstream input{file, std::ios::binary};
  if (!input) throw std::invalid_argument(file.string() + ": " + reason());
  return input;
}

std::string read_whole(const std::filesystem::path& file) {
  auto input = open_input(file);
  std::string text{std::istreambuf_iterator<char>(input), {}};
  if (input.bad()) throw std::runtime_error(file.string() + ": cannot be read");
  return text;
}

std::ofstream open_output(const std::filesystem::path& file) {
  errno = 0;
  std::ofstream output{file, std::ios::binary};
  if (!output)
    throw std::invalid_argument(file.string() + ": cannot be written: " + reason_at(file));
  return output;
}

std::string why_unwritten(std::ostream& failed) {
  failed.clear();
  errno = 0;
  failed.put('\n').flush();
  std::string why = errno != 0 ? reason() : "not everything was written; is the disk full?";
  failed.setstate(std::ios::badbit);
  return why;
}

void close_output(std::ofstream& output, const std::filesystem::path& file) {
  const std::string unwritten = output.flush() ? "" : why_unwritten(output);
  errno = 0;
  output.close();
  if (!output)
    throw std::runtime_error(file.string() +
                             ": cannot be written: " + (unwritten.empty() ? reason() : unwritten));
}

namespace {

constexpr const char* standard_output = "-";

// The target of a symbolic link, so that the link is kept.
std::filesystem::path resolved(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_symlink(file, error)) return file;
  if (std::filesystem::exists(file, error)) return std::filesystem::canonical(file);
  return file.parent_path() / std::filesystem::read_symlink(file);
}

bool is_moved_into(const std::filesystem::path& place) {
  if (place == standard_output) return false;
  std::error_code error;
  const auto type = std::filesystem::status(place, error).type();
  return type == std::filesystem::file_type::not_found ||
         type == std::filesystem::file_type::regular;
}

bool is_same(const std::filesystem::path& one, const std::filesystem::path& other) {
  if (one.empty() || other.empty() || !is_moved_into(one) || !is_moved_into(other)) return false;
  std::error_code missing;
  if (std::filesystem::equivalent(one, other, missing)) return true;
  return std::filesystem::weakly_canonical(one, missing) ==
         std::filesystem::weakly_canonical(other, missing);
}

}  // namespace

void check_outputs(std::span<const Output> outputs, std::span<const std::filesystem::path> inputs) {
  const auto refuse = [](const Output& output, const std::string& is) {
    throw std::invalid_argument(output.option + ": " + output.file.string() + " is " + is +
                                "; name another file");
  };
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const std::filesystem::path& input : inputs)
      if (is_same(outputs[i].file, input)) refuse(outputs[i], "what is read");
    for (std::size_t j = 0; j < i; ++j)
      if (is_same(outputs[i].file, outputs[j].file) ||
          (outputs[i].file == standard_output && outputs[j].file == standard_output))
        refuse(outputs[i], outputs[j].option + " too");
  }
}

void check_writable(const std::filesystem::path& file) {
  if (is_moved_into(file)) const WholeFile probe(file);
}

namespace {

// Keeps the group if only the owner cannot be kept. If the group cannot be kept either, the
// writer's group must not get the rights that the former group had.
void keep_owner_and_mode(int copy, const struct stat& replaced) {
  mode_t mode = replaced.st_mode & 07777U;
  if (::fchown(copy, replaced.st_uid, replaced.st_gid) != 0 &&
      ::fchown(copy, static_cast<uid_t>(-1), replaced.st_gid) != 0)
    mode &= ~static_cast<mode_t>(S_IRWXG);
  static_cast<void>(::fchmod(copy, mode) == 0);
}

}  // namespace

WholeFile::WholeFile(const std::filesystem::path& file) : place_(file), written_(file) {
  if (!is_moved_into(file)) {
    if (place_ != standard_output) output_ = open_output(file);
    return;
  }
  place_ = resolved(file);
  struct stat replaced {};
  const bool replaces = ::stat(place_.c_str(), &replaced) == 0;
  // O_EXCL: never the copy of another writer, nor the target of a link that somebody put there.
  for (int i = 0; !copy_; ++i) {
    written_ = fmt::format("{}.{}-{}.partial", place_.string(), ::getpid(), i);
    copy_ = FileDescriptor(
        ::open(written_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, replaces ? 0600 : 0666));
    if (!copy_ && errno != EEXIST)
      throw std::invalid_argument(file.string() + ": cannot be written: " + reason_at(written_));
  }
  // Opened by its descriptor: the name may belong to another file by now.
  errno = 0;
  output_.open(fmt::format("/proc/self/fd/{}", copy_.get()), std::ios::binary);
  if (!output_) {
    const std::string why = errno == ENOENT ? "/proc is not mounted; mount it" : reason();
    ::unlink(written_.c_str());
    throw std::invalid_argument(file.string() + ": cannot be written: " + why);
  }
  if (replaces) keep_owner_and_mode(copy_.get(), replaced);
}

WholeFile::~WholeFile() {
  if (finished_ || written_ == place_) return;
  output_.close();
  std::error_code ignored;
  std::filesystem::remove(written_, ignored);
}

std::ostream& WholeFile::stream() {
  return place_ == standard_output ? std::cout : output_;
}

void WholeFile::finish() {
  if (place_ != standard_output) close_output(output_, place_);
  if (written_ != place_) {
    std::error_code error;
    // A file is replaced only by one that is on the disk: the power may fail.
    if (std::filesystem::exists(place_, error) && ::fsync(copy_.get()) != 0)
      throw std::runtime_error(place_.string() + ": cannot be written: " + why_not_written(errno));
    std::filesystem::rename(written_, place_, error);
    if (error)
      throw std::runtime_error(place_.string() + ": cannot be written: " + error.message());
  }
  finished_ = true;
}

void write_whole(const std::filesystem::path& file, std::string_view text) {
  WholeFile whole(file);
  whole.stream() << text;
  whole.finish();
}

}  // namespace odomd::tools
