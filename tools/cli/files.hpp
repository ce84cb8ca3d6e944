// Opens files for reading and writing, or says in one line why that cannot be.
#pragma once

#include <filesystem>
#include <fstream>
#include <ostream>
#include <span>
#include <string>

namespace odomd::tools {

/// Throws std::invalid_argument: "x.csv: no such file", "x.csv: is a directory, not a file", ...
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);

/// Opens a file for writing. Throws std::invalid_argument where that cannot be.
[[nodiscard]] std::ofstream open_output(const std::filesystem::path& file);

/// Before long work whose result goes there: throws std::invalid_argument where it could not be
/// written. The file stays as it is.
void check_writable(const std::filesystem::path& file);

/// A file that an option names to be written; an empty name: none.
struct Output {
  std::string option;
  std::filesystem::path file;
};

/// What is read must outlive what is written, and what is written needs a file each: throws
/// std::invalid_argument that names the option. Pipes and devices may be both.
void check_outputs(std::span<const Output> outputs, std::span<const std::filesystem::path> inputs);

/// Why a stream has failed, however long ago: it is tried once more. "No space left on device".
[[nodiscard]] std::string why_unwritten(std::ostream& failed);

/// Flushes and closes; throws std::runtime_error when something could not be written.
void close_output(std::ofstream& output, const std::filesystem::path& file);

/// A file that is there whole or not at all: it is written beside its place, as FILE.partial, and
/// moved there by finish(). What is no regular file (a pipe, a device) is written as it comes.
class WholeFile {
 public:
  /// Throws std::invalid_argument where it cannot be written.
  explicit WholeFile(const std::filesystem::path& file);
  ~WholeFile();  ///< without finish(): nothing has happened to the file
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  [[nodiscard]] std::ostream& stream() { return output_; }
  /// Throws std::runtime_error when something could not be written.
  void finish();

 private:
  std::filesystem::path place_;
  std::filesystem::path written_;  // the same where it is written as it comes
  std::ofstream output_;
  bool finished_ = false;
};

}  // namespace odomd::tools
