#include "base/input_file.hpp"

#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/statfs.h>

#include <array>
#include <fstream>

namespace odomd {
namespace {

constexpr std::array<Packing, 5> packings{{{"\x1F\x8B", "gzip", "gunzip -k", "zcat"},
                                           {"\xFD\x37zXZ", "xz", "unxz -k", "xzcat"},
                                           {"\x28\xB5\x2F\xFD", "zstd", "unzstd", "zstdcat"},
                                           {"BZh", "bzip2", "bunzip2 -k", "bzcat"},
                                           {"PK\x03\x04", "zip", "unzip", "unzip -p"}}};

}  // namespace

const Packing* packing_of(std::string_view head) noexcept {
  for (const Packing& packing : packings)
    if (head.starts_with(packing.begins)) return &packing;
  return nullptr;
}

std::string_view kind_of_no_file(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || S_ISREG(status.st_mode)) return {};
  if (S_ISDIR(status.st_mode)) return "a directory";
  if (S_ISSOCK(status.st_mode)) return "a socket";
  if (!S_ISFIFO(status.st_mode)) return "a device";
  struct statfs system {};
  const bool named = ::statfs(file.c_str(), &system) != 0 || system.f_type != PIPEFS_MAGIC;
  return named ? "a named pipe" : "a pipe";
}

std::string problem_with_input(const std::filesystem::path& file) {
  const std::string_view kind = kind_of_no_file(file);
  if (kind == "a pipe") return {};
  if (!kind.empty()) return "is " + std::string(kind) + "; name a file";
  std::array<char, 6> head{};
  std::ifstream(file, std::ios::binary).read(head.data(), head.size());
  if (const Packing* const packing = packing_of({head.data(), head.size()}))
    return "is packed; unpack it: " + std::string(packing->to_file) + ' ' + file.string();
  return {};
}

}  // namespace odomd
