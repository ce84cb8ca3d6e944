// How long odomd takes from its start to its first pose: first_pose ODOMD CONFIG LOG SHM [STARTS]
//
// Starts the daemon with the log's beginning in its standard input, waits in shared memory for the
// first pose of this instance, kills it with SIGKILL and starts the next, which resumes from the
// last pose. Prints median and maximum, in ms, of the time from before the start to the first pose
// that is published, and to the first valid one (not initialising).
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <odom/odom.h>

#include "tests/process.hpp"

namespace {

constexpr std::int64_t timeout_ns = 10'000'000'000;

std::int64_t now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Times {
  std::int64_t first_ns = 0;
  std::int64_t worth_something_ns = 0;
};

// When a client sees the first pose, and the first past initialising; both since `began_ns`.
Times await_poses(const std::string& shm, std::int64_t began_ns) {
  Times times;
  while (now_ns() - began_ns < timeout_ns) {
    odom_client* client = nullptr;
    odom_pose pose{};
    odom_info info{};
    if (odom_open(shm.c_str(), &client) == ODOM_OK &&
        odom_get_info(client, &info, sizeof info) <= ODOM_STALE &&
        info.writer_start_ns > began_ns && odom_latest(client, &pose, sizeof pose) == ODOM_OK) {
      const std::int64_t passed_ns = now_ns() - began_ns;
      if (times.first_ns == 0) times.first_ns = passed_ns;
      if (pose.mode != ODOM_INITIALISING) times.worth_something_ns = passed_ns;
    }
    odom_close(client);
    if (times.worth_something_ns != 0) return times;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  throw std::runtime_error("no pose within ten seconds");
}

void print(const char* what, std::vector<std::int64_t> times) {
  std::sort(times.begin(), times.end());
  const auto ms = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-6; };
  std::cout << std::fixed << std::setprecision(1) << what << " median "
            << ms(times[times.size() / 2]) << " max " << ms(times.back()) << '\n';
}

void measure(const std::string& odomd, const std::string& config, const std::string& log,
             const std::string& shm, int starts) {
  std::string input(60'000, '\0');
  std::ifstream file(log);
  file.read(input.data(), static_cast<std::streamsize>(input.size()));
  input.resize(static_cast<std::size_t>(file.gcount()));
  std::vector<std::int64_t> first;
  std::vector<std::int64_t> worth_something;
  for (int i = 0; i < starts; ++i) {
    const std::int64_t began_ns = now_ns();
    const odomd::Process started({odomd, "--config", config, "--can", "-", "--shm", shm,
                                  "--log-level", "error", "--status-socket", config + ".sock"},
                                 "/dev/stderr", "/dev/stderr");
    started.feed(input);
    const Times times = await_poses(shm, began_ns);
    first.push_back(times.first_ns);
    worth_something.push_back(times.worth_something_ns);
  }
  print("first_pose", first);
  print("worth_something", worth_something);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  try {
    measure(argv[1], argv[2], argv[3], argv[4],
            argc > 5 ? static_cast<int>(std::strtol(argv[5], nullptr, 10)) : 20);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "first_pose: " << error.what() << '\n';
    return 1;
  }
}
