// The example in docs/shm.md is a part of the program that check_installed.sh builds and runs.
#include <fstream>
#include <iterator>

#include "tests/gtest.hpp"

namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string code_block(const std::string& document, const std::string& language) {
  const std::string opening = "```" + language + "\n";
  const std::size_t start = document.find(opening);
  if (start == std::string::npos) return {};
  const std::size_t begin = start + opening.size();
  return document.substr(begin, document.find("```", begin) - begin);
}

TEST(Documentation, TheExampleIsOfTheProgramThatIsTested) {
  const std::string example = code_block(text_of(ODOMD_SOURCE_DIR "/docs/shm.md"), "c");
  const std::string program = text_of(ODOMD_SOURCE_DIR "/tests/shm_api/consumer/pose.c");
  ASSERT_FALSE(example.empty());
  EXPECT_NE(program.find(example), std::string::npos);
}

}  // namespace
