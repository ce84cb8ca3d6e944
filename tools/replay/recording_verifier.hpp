// Compares a replayed drive with the recorded poses, bit by bit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "tools/replay/recording.hpp"

namespace odomd::tools {

class RecordingVerifier {
 public:
  /// Opens the recorded poses. Throws std::invalid_argument if they cannot be used.
  explicit RecordingVerifier(const std::filesystem::path& folder);

  /// Compares a replayed tick; keeps the first difference.
  void take(const daemon::TickRecord& record, const BeatRow& live);

  /// One line about the first difference; empty while there is none.
  [[nodiscard]] const std::optional<std::string>& difference() const { return difference_; }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
  [[nodiscard]] std::uint64_t rows() const { return rows_; }  ///< compared rows of the pose file

 private:
  [[nodiscard]] std::optional<std::string> differing_column(const daemon::TickRecord& record,
                                                            const BeatRow& live);

  std::filesystem::path file_;
  std::ifstream poses_;
  std::string header_;
  std::uint64_t ticks_ = 0;
  std::uint64_t rows_ = 0;
  std::optional<std::string> difference_;
};

}  // namespace odomd::tools
