#include "tools/live/listen.hpp"

#include <fmt/format.h>
#include <net/if.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <thread>

#include "can_protocol/sources/socketcan.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {

std::vector<can::Frame> listen(const std::vector<std::string>& interfaces, can::BusNames& buses,
                               int receive_buffer, std::chrono::duration<double> duration) {
  using std::chrono::steady_clock;
  std::vector<std::unique_ptr<can::SocketCanSource>> sources;
  for (const std::string& interface : interfaces) {
    if (::if_nametoindex(interface.c_str()) == 0)
      throw std::invalid_argument(
          interface + ": no such interface; ip -brief link show type can lists the CAN interfaces");
    const auto bus = buses.index_of(interface);
    if (!bus)
      throw std::invalid_argument(
          fmt::format("{}: at most {} buses; name fewer", interface, can::max_buses));
    can::SocketCanSettings settings;
    settings.bus = *bus;
    settings.receive_buffer = receive_buffer;
    sources.push_back(std::make_unique<can::SocketCanSource>(interface, settings));
  }
  std::vector<can::Frame> frames;
  std::vector<can::Frame> some(can::max_frames_per_drain);
  Interrupt interrupt;
  constexpr std::chrono::milliseconds pause{5};
  const auto end = steady_clock::now() + duration;
  while (steady_clock::now() < end && !interrupt.requested()) {
    std::this_thread::sleep_for(pause);
    for (const auto& source : sources) {
      const auto count = static_cast<std::ptrdiff_t>(source->drain(some, 0, 0));
      frames.insert(frames.end(), some.begin(), some.begin() + count);
    }
  }
  std::ranges::stable_sort(frames, {}, &can::Frame::time_ns);
  return frames;
}

}  // namespace odomd::tools
