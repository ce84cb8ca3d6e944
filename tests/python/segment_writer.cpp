// A segment writer driven by commands, for tests of clients in other languages.
//   segment_writer PATH PERIOD_NS
// It reads commands from standard input, one per line, and answers each with "ok" on standard
// output. Meanwhile it sends a heartbeat, until "silence". It ends when its input ends.
//   publish [FIELD=VALUE]...   the previous pose with the next tick, the present time and these
//                              changes; fields of odom_details too
//   silence                    no further heartbeat; the last one is set to long ago
//   missed N                   counts missed cycles
#include <poll.h>
#include <unistd.h>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <variant>

#include "tests/shm_api/segment_fixture.hpp"

namespace {

namespace shm = odomd::shm;

class Segment {
 public:
  Segment(const std::string& path, std::int64_t period_ns)
      : period_ns_(period_ns), writer_({.name = path, .slots = 256}, info(period_ns)) {
    pose_.mode = ODOM_TRACKING;
  }

  void beat() {
    if (!silent_) writer_.set_heartbeat(shm::testing::now_ns());
  }

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string command;
    words >> command;
    if (command == "publish") return publish(words);
    if (command == "missed") {
      std::uint64_t cycles = 0;
      words >> cycles;
      return writer_.count_missed(cycles);
    }
    if (command != "silence") throw std::invalid_argument("no such command: " + line);
    silent_ = true;
    writer_.set_heartbeat(shm::testing::now_ns() - 100 * period_ns_);
  }

 private:
  static odom_info info(std::int64_t period_ns) {
    odom_info info = shm::testing::test_info(period_ns);
    info.front_axle = 0.175;
    info.rear_axle = 0.085;
    return info;
  }

  void publish(std::istream& fields) {
    ++pose_.tick;
    pose_.time_ns = shm::testing::now_ns();
    for (std::string field; fields >> field;) {
      const std::size_t equals = field.find('=');
      set(field.substr(0, equals), field.substr(equals + 1));
    }
    writer_.publish(pose_, details_);
    beat();
    writer_.wake_clients();
  }

  void set(const std::string& name, const std::string& value) {
    using Field = std::variant<double*, std::int64_t*, std::uint64_t*, std::uint32_t*>;
    const std::map<std::string, Field> fields{
        {"tick", &pose_.tick},
        {"time_ns", &pose_.time_ns},
        {"x", &pose_.x},
        {"y", &pose_.y},
        {"yaw", &pose_.yaw},
        {"odom_x", &pose_.odom_x},
        {"vx", &pose_.vx},
        {"variance_x", &pose_.covariance[0]},
        {"covariance_xy", &pose_.covariance[1]},
        {"variance_y", &pose_.covariance[3]},
        {"variance_yaw", &pose_.covariance[5]},
        {"mode", &pose_.mode},
        {"conditions", &pose_.conditions},
        {"reset_count", &pose_.reset_count},
        {"health", &pose_.health},
        {"jump_yaw", &pose_.jump_yaw},
        {"gyro_bias", &details_.gyro_bias},
        {"camera_messages", &details_.camera_messages},
    };
    const auto found = fields.find(name);
    if (found == fields.end()) throw std::invalid_argument("no such field: " + name);
    if (auto* const* number = std::get_if<double*>(&found->second))
      **number = std::stod(value);
    else
      std::visit([&](auto* field) { std::istringstream(value) >> *field; }, found->second);
  }

  std::int64_t period_ns_;
  shm::Writer writer_;
  odom_pose pose_{};
  odom_details details_{};
  bool silent_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const std::int64_t period_ns = std::strtoll(argv[2], nullptr, 10);
    Segment segment(argv[1], period_ns);
    std::cout << "ok" << std::endl;
    std::string pending;
    for (pollfd input{STDIN_FILENO, POLLIN, 0};;) {
      segment.beat();
      if (poll(&input, 1, static_cast<int>(period_ns / 4'000'000 + 1)) <= 0) continue;
      char buffer[4096];
      const ssize_t size = read(STDIN_FILENO, buffer, sizeof buffer);
      if (size <= 0) return 0;
      pending.append(buffer, static_cast<std::size_t>(size));
      for (std::size_t end = 0; (end = pending.find('\n')) != std::string::npos;) {
        segment.obey(pending.substr(0, end));
        pending.erase(0, end + 1);
        std::cout << "ok" << std::endl;
      }
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
