#include "tools/bridge/bridge.hpp"

#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "base/file_descriptor.hpp"
#include "tools/cli/csv.hpp"
#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

struct Address {
  std::string host;
  std::string port;
};

Address parse_address(const std::string& text) {
  const auto bad = [&text] {
    return std::invalid_argument("--udp " + tools::quoted(text) +
                                 ": not HOST:PORT; such as 127.0.0.1:9870 or [::1]:9870");
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) throw bad();
  Address address{text.substr(0, colon), text.substr(colon + 1)};
  if (address.host.starts_with('[') && address.host.ends_with(']'))
    address.host = address.host.substr(1, address.host.size() - 2);
  else if (address.host.find(':') != std::string::npos)
    throw bad();
  const unsigned port = parse_number<std::uint16_t>(address.port).value_or(0);
  if (port == 0 || address.host.empty()) throw bad();
  return address;
}

struct FreeAddresses {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

FileDescriptor connect_udp(const std::string& text) {
  const Address address = parse_address(text);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_DGRAM;
  wanted.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &wanted, &found);
  if (error != 0) throw std::runtime_error("--udp " + text + ": " + ::gai_strerror(error));
  const std::unique_ptr<addrinfo, FreeAddresses> list(found);
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    FileDescriptor socket(::socket(one->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (socket.get() >= 0 && ::connect(socket.get(), one->ai_addr, one->ai_addrlen) == 0)
      return socket;
  }
  throw std::runtime_error("--udp " + text + ": " + std::strerror(errno));
}

class UdpSink : public Sink {
 public:
  explicit UdpSink(const std::string& address) : socket_(connect_udp(address)) {
    name_ = "udp " + address;
  }

  void send(const BridgeSample& sample) override {
    const std::string text = sample_json(sample);
    ssize_t sent = -1;
    for (int attempt = 0; attempt < 2 && sent < 0; ++attempt) {
      sent = ::send(socket_.get(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent >= 0 || errno != ECONNREFUSED) break;
      // The error is about the previous datagram (nobody listens); the present one is not sent yet.
      if (counts_.sent > 0) --counts_.sent;
      ++counts_.dropped;
    }
    ++(sent < 0 ? counts_.dropped : counts_.sent);
  }

 private:
  FileDescriptor socket_;
};

}  // namespace

std::string sample_json(const BridgeSample& sample) {
  std::string text = "{\"timestamp\":";
  append_seconds(text, sample.realtime_ns);
  nlohmann::ordered_json fields;
  for (const PoseField& field : pose_fields())
    set_field(fields, field, field.value(sample.pose, sample.details));
  text += ",\"odomd\":" + fields.dump() + '}';
  return text;
}

std::unique_ptr<Sink> open_udp(const std::string& address) {
  return std::make_unique<UdpSink>(address);
}

}  // namespace odomd::tools
