// Opens files for reading and writing, or reports in one line why that fails.
#pragma once

#include <filesystem>
#include <fstream>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

#include "base/file_descriptor.hpp"

namespace odomd::tools {

/// Throws std::invalid_argument: "x.csv: no such file", "x.csv: is a directory; name a file", ...
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);

/// Opens a file for writing. Throws std::invalid_argument if that fails.
[[nodiscard]] std::ofstream open_output(const std::filesystem::path& file);

/// The whole content of a file. Throws like open_input().
[[nodiscard]] std::string read_whole(const std::filesystem::path& file);

/// For use before long work: throws std::invalid_argument if the file could not be written. The
/// file is not changed.
void check_writable(const std::filesystem::path& file);

/// An output file that an option names; an empty name: none.
struct Output {
  std::string option;
  std::filesystem::path file;
};

/// Throws std::invalid_argument with the option's name if an output would overwrite an input or
/// another output. Pipes and devices are exempt; "-" may be an input and one output.
void check_outputs(std::span<const Output> outputs, std::span<const std::filesystem::path> inputs);

/// The reason why a stream failed, from a new attempt to write: "No space left on device".
[[nodiscard]] std::string why_unwritten(std::ostream& failed);

/// Flushes and closes; throws std::runtime_error when something could not be written.
void close_output(std::ofstream& output, const std::filesystem::path& file);

/// A file that exists completely or not at all: it is written as FILE.PID-N.partial in the same
/// folder and renamed by finish(); a process that is killed leaves that copy. A file that it
/// replaces keeps its mode, its symbolic link and, as far as the user may, its owner and group, and
/// is only replaced once the new one is on the disk. Of several writers the last to finish wins.
/// Anything but a regular file (a pipe, a device, or standard output, which is called "-") is
/// written directly.
class WholeFile {
 public:
  /// Throws std::invalid_argument if it cannot be written.
  explicit WholeFile(const std::filesystem::path& file);
  ~WholeFile();  ///< without finish() the file is unchanged
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  [[nodiscard]] std::ostream& stream();
  /// Throws std::runtime_error when something could not be written.
  void finish();

 private:
  std::filesystem::path place_;
  std::filesystem::path written_;  // equals the target if it is written directly
  FileDescriptor copy_;            // of written_, unless it is written directly
  std::ofstream output_;
  bool finished_ = false;
};

/// Writes this text as a WholeFile.
void write_whole(const std::filesystem::path& file, std::string_view text);

}  // namespace odomd::tools
