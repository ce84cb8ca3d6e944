#include "tools/live/attach.hpp"

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

namespace odomd::tools {

std::string segment_asked_for(const std::string& name) {
  if (!name.empty()) return name;
  const char* named = std::getenv("ODOM_SHM");
  return named != nullptr ? std::string{"$ODOM_SHM = "} + named : "/odomd, /run/odomd/*/pose";
}

odom::Client attach(const std::string& name, double wait_s) {
  using std::chrono::steady_clock;
  const auto start = steady_clock::now();
  while (true) {
    auto opened = odom::Client::open(name.empty() ? nullptr : name.c_str());
    if (opened.has_value()) return std::move(opened.value);
    if (opened.status == ODOM_INVALID) {
      throw std::invalid_argument(segment_asked_for(name) +
                                  ": not a name of a segment; use /odomd or a path");
    }
    const std::chrono::duration<double> waited = steady_clock::now() - start;
    if (opened.status != ODOM_NO_SEGMENT || waited.count() >= wait_s) {
      throw std::runtime_error(segment_asked_for(name) + ": " + opened.message());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }
}

}  // namespace odomd::tools
