#include "tools/fault/live.hpp"

#include <net/if.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "can_protocol/bus_names.hpp"

namespace odomd::fault {
namespace {

constexpr std::int64_t maintenance_period_ns = 200'000'000;
constexpr int max_messages = 64;  // per camera and call

std::unique_ptr<can::SocketCanSource> open_interface(const std::string& name, std::uint8_t bus) {
  if (::if_nametoindex(name.c_str()) == 0)
    throw std::invalid_argument(name +
                                ": no such CAN interface; `ip link show type can` lists "
                                "those, `type vcan` the virtual ones");
  return std::make_unique<can::SocketCanSource>(name, can::SocketCanSettings{.bus = bus});
}

}  // namespace

BusRelay::BusRelay(const std::string& from, const std::string& to, const daemon::Config& config,
                   std::span<const can::Database> databases, std::span<const Fault> faults,
                   std::int64_t start_ns)
    : output_((from == to)
                  ? throw std::invalid_argument(
                        "--to: is the interface of --from; frames would circulate endlessly")
                  : to),
      arrived_(can::max_frames_per_drain) {
  can::BusNames buses;
  for (const std::string& name : daemon::expected_buses(config)) buses.index_of(name);
  const auto bus = buses.index_of(from);
  if (!bus)
    throw std::invalid_argument(from + ": too many buses together with those of [can.signals]");
  source_ = open_interface(from, *bus);
  injector_.emplace(config, databases, buses.all(), faults);
  injector_->start(start_ns);
}

void BusRelay::pass_on(std::int64_t now_ns) {
  if (now_ns - maintained_ns_ > maintenance_period_ns) {
    source_->maintain();
    maintained_ns_ = now_ns;
    if (source_->link() == can::LinkState::gone)
      throw std::runtime_error(source_->name() + ": the interface has gone");
  }
  leaving_.clear();
  const std::size_t count = source_->drain(arrived_, now_ns, now_ns);
  for (std::size_t i = 0; i < count; ++i) injector_->take(arrived_[i], leaving_);
  injector_->release(now_ns, leaving_);
  std::erase_if(leaving_, [](const can::Frame& one) { return one.kind == can::FrameKind::error; });
  output_.send(leaving_);
  relayed_.received += count;
  relayed_.sent += leaving_.size();
}

CameraRelay::CameraRelay(const std::filesystem::path& from, const std::string& to, double wait_s,
                         std::span<const Fault> faults, std::int64_t start_ns)
    : socket_({.file = daemon::socket_at(from),
               .type = daemon::SocketType::packets,
               .fix = "name another path by --camera-from"}),
      feed_(to, wait_s, tools::Admission::assumed),
      injector_(faults, start_ns) {}

void CameraRelay::take(const odom_camera_message& message, std::int64_t now_ns) {
  clock_ = static_cast<odom_clock>(message.clock);
  injector_.take({.capture_ns = message.capture_ns,
                  .arrival_ns = now_ns,
                  .x = message.x,
                  .y = message.y,
                  .yaw = message.yaw,
                  .sigma_x = message.sigma_x,
                  .sigma_y = message.sigma_y,
                  .sigma_yaw = message.sigma_yaw},
                 leaving_);
}

bool CameraRelay::read(int connection, std::int64_t now_ns) {
  for (int i = 0; i < max_messages; ++i) {
    odom_camera_message message{};
    const ssize_t size = ::recv(connection, &message, sizeof message, MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    if (size == 0) return false;
    ++relayed_.received;
    if (size != sizeof message || message.magic != ODOM_CAMERA_MAGIC ||
        message.version != ODOM_CAMERA_VERSION || message.clock > ODOM_CLOCK_LOG) {
      ++relayed_.malformed;
    } else {
      take(message, now_ns);
    }
  }
  return true;
}

void CameraRelay::pass_on(std::int64_t now_ns) {
  while (FileDescriptor connection = socket_.accept())
    connections_.push_back(std::move(connection));
  leaving_.clear();
  std::erase_if(connections_, [&](const FileDescriptor& one) { return !read(one.get(), now_ns); });
  injector_.release(now_ns, leaving_);
  for (const estimator::CameraPose& pose : leaving_)
    ++(feed_.send(pose, clock_) ? relayed_.sent : relayed_.refused);
}

}  // namespace odomd::fault
