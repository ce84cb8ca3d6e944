// A file in its own temporary directory, removed at the end of the test.
#pragma once

#include "tests/scratch.hpp"

namespace odomd::can {

class TemporaryFile {
 public:
  TemporaryFile(std::string_view name, std::string_view content)
      : path_(scratch_.write(name, content)) {}

  [[nodiscard]] std::string path() const { return path_.string(); }
  [[nodiscard]] std::filesystem::path directory() const { return path_.parent_path(); }

 private:
  Scratch scratch_;
  std::filesystem::path path_;
};

}  // namespace odomd::can
