// The trials in a file, so that a restarted search does not repeat them.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "tools/tune/parameter.hpp"
#include "tools/tune/trials.hpp"

namespace odomd::tools {

/// JSON, a line a trial, each written as soon as the trial is done; a last line that is cut off is
/// tried again. One thread. Without a file it remembers while it lives.
class TrialLog {
 public:
  /// Reads what is there. Throws std::invalid_argument where the file is something else, or of
  /// other keys or drives, or while another run has it.
  TrialLog(std::filesystem::path file, std::span<const Parameter> parameters,
           const std::vector<std::string>& drives);

  [[nodiscard]] const TrialOutcome* find(const Values& values) const;
  /// Throws std::runtime_error when it cannot be written.
  void add(const Values& values, const TrialOutcome& outcome);

  /// Checks that the present configuration gives the same errors as before: else the program, a
  /// drive or a setting has changed, and it throws std::invalid_argument.
  void check_unchanged(const Values& as_configured, const TrialOutcome& as_it_is) const;

  [[nodiscard]] std::size_t read() const { return read_; }

 private:
  void take_line(const std::string& line, std::size_t number);

  std::filesystem::path file_;
  FileDescriptor lock_;  ///< of the file, while this lives
  std::string header_;
  std::map<Values, TrialOutcome> outcomes_;
  std::size_t read_ = 0;
  std::ofstream output_;
};

}  // namespace odomd::tools
