// Measures restarts of the service for the lab's tests: restart_probe COMMAND...
//
//   pose KILL|STOP PID SHM   send odomd this signal, and wait for the first pose after the restart,
//                            as a client does
//   notify FILE              an empty notify service: reports to systemd that it is ready, and
//                            writes the time to FILE
//   ready PID FILE           kill that service, and wait for its restart
//
// `pose` and `ready` print one JSON object: `elapsed_ms` from the signal to the first pose or to
// the readiness; `pose` also prints the last pose before and the first one after.
#include <sys/types.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include <chrono>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include <odom/odom.hpp>

namespace {

constexpr std::chrono::seconds timeout{60};

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

double ms_since(std::int64_t begin_ns, std::int64_t end_ns) {
  return static_cast<double>(end_ns - begin_ns) * 1e-6;
}

/// Waits actively: otherwise systemd runs a timer, such as RestartSec=, up to 250 ms late, by
/// chance.
void await(const std::function<bool()>& done, const char* what) {
  const auto begin = std::chrono::steady_clock::now();
  for (unsigned turn = 0; !done(); ++turn) {
    if (std::chrono::steady_clock::now() > begin + timeout)
      throw std::runtime_error(std::string("no ") + what);
    if (turn % 10 == 0) sd_notify(0, "STATUS=waits for a service");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

std::int64_t send_signal(int signal, const std::string& pid) {
  const std::int64_t now_ns = monotonic_ns();
  if (kill(std::stoi(pid), signal) != 0)
    throw std::runtime_error("cannot signal " + pid + ": " + std::strerror(errno));
  return now_ns;
}

nlohmann::json as_json(const odom::DetailedPose& seen) {
  const auto& [pose, details] = seen;
  return {{"x", pose.x},
          {"y", pose.y},
          {"restarted", (pose.conditions & ODOM_COND_RESTARTED) != 0},
          {"reset_count", pose.reset_count},
          {"calibrations",
           {details.gyro_bias, details.gyro_scale, details.accel_bias_x, details.accel_bias_y,
            details.wheel_scale, details.steering_offset, details.stiffness_scale}}};
}

nlohmann::json pose_after(int signal, const std::string& pid, const std::string& shm) {
  auto client = odom::Client::open(shm.c_str());
  if (!client) throw std::runtime_error(client.message());
  auto before = client->latest_details();
  if (!before) throw std::runtime_error(before.message());
  const std::uint64_t instance = client->info()->instance_id;

  const std::int64_t sent_ns = send_signal(signal, pid);
  odom::Result<odom::DetailedPose> after;
  await(
      [&] {
        after = client->latest_details();
        if (client->info()->instance_id != instance)
          return after && after->pose.mode != ODOM_INITIALISING;
        if (after.has_value()) before = after;
        return false;
      },
      "pose of a successor");
  const std::int64_t seen_ns = monotonic_ns();
  return {{"elapsed_ms", ms_since(sent_ns, seen_ns)},
          {"gap_ms", ms_since(before->pose.time_ns, after->pose.time_ns)},
          {"before", as_json(*before)},
          {"after", as_json(*after)}};
}

// The file is replaced atomically, so that a reader always finds a time.
[[noreturn]] void serve(const std::string& file) {
  sd_notify(0, "READY=1");
  const std::int64_t ready_ns = monotonic_ns();
  const std::string temporary = file + ".tmp";
  std::ofstream(temporary) << ready_ns << '\n';
  if (std::rename(temporary.c_str(), file.c_str()) != 0) throw std::runtime_error(file);
  for (;;) pause();
}

std::int64_t time_in(const std::string& file) {
  std::int64_t time_ns = 0;
  std::ifstream(file) >> time_ns;
  return time_ns;
}

nlohmann::json ready_after_kill(const std::string& pid, const std::string& file) {
  const std::int64_t killed_ns = send_signal(SIGKILL, pid);
  await([&] { return time_in(file) > killed_ns; }, "successor");
  return {{"elapsed_ms", ms_since(killed_ns, time_in(file))}};
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string command = words.empty() ? "" : words[0];
  if (command == "pose" && words.size() == 4 && (words[1] == "KILL" || words[1] == "STOP")) {
    std::cout << pose_after(words[1] == "KILL" ? SIGKILL : SIGSTOP, words[2], words[3]) << '\n';
  } else if (command == "notify" && words.size() == 2) {
    serve(words[1]);
  } else if (command == "ready" && words.size() == 3) {
    std::cout << ready_after_kill(words[1], words[2]) << '\n';
  } else {
    std::cerr << "usage: restart_probe pose KILL|STOP PID SHM | notify FILE | ready PID FILE\n";
    return 2;
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << "restart_probe: " << error.what() << '\n';
  return 1;
}
