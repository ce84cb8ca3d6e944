// Opens files for reading and writing, or reports in one line why that fails.
#pragma once

#include <filesystem>
#include <fstream>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

namespace odomd::tools {

/// Throws std::invalid_argument: "x.csv: no such file", "x.csv: is a directory; name a file", ...
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);

/// Opens a file for writing. Throws std::invalid_argument if that fails.
[[nodiscard]] std::ofstream open_output(const std::filesystem::path& file);

/// All that is in a file. Throws like open_input().
[[nodiscard]] std::string read_whole(const std::filesystem::path& file);

/// For use before long work: throws std::invalid_argument if the file could not be written. The
/// file is not changed.
void check_writable(const std::filesystem::path& file);

/// A file that an option names to be written; an empty name: none.
struct Output {
  std::string option;
  std::filesystem::path file;
};

/// Inputs must not be overwritten, and each output needs its own file: throws std::invalid_argument
/// that names the option. Pipes, devices and "-", standard output, may be both.
void check_outputs(std::span<const Output> outputs, std::span<const std::filesystem::path> inputs);

/// Why a stream has failed, even long ago: the write is tried once more. "No space left on device".
[[nodiscard]] std::string why_unwritten(std::ostream& failed);

/// Flushes and closes; throws std::runtime_error when something could not be written.
void close_output(std::ofstream& output, const std::filesystem::path& file);

/// A file that exists completely or not at all: it is written as FILE.partial in the same folder
/// and renamed by finish(). Anything but a regular file (a pipe, a device, or standard output,
/// which is called "-") is written directly.
class WholeFile {
 public:
  /// Throws std::invalid_argument if it cannot be written.
  explicit WholeFile(const std::filesystem::path& file);
  ~WholeFile();  ///< without finish(): nothing has happened to the file
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  [[nodiscard]] std::ostream& stream();
  /// Throws std::runtime_error when something could not be written.
  void finish();

 private:
  std::filesystem::path place_;
  std::filesystem::path written_;  // the same if it is written directly
  std::ofstream output_;
  bool finished_ = false;
};

/// A WholeFile of this text.
void write_whole(const std::filesystem::path& file, std::string_view text);

}  // namespace odomd::tools
