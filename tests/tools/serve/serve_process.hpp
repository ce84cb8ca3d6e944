// odom serve as a process, and a client of it.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>

#include <memory>

#include "tests/tools/child.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

inline constexpr std::string_view token = "0123456789abcdef-secret";

class Client {
 public:
  explicit Client(int port, int receive_buffer = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0)
      ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    const timeval limit{10, 0};
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  void send(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t sent = ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
  }
  /// Reads until the server closes or has sent `until`; with MSG_DONTWAIT, only what has arrived.
  std::string& receive(std::string_view until = "\xff", int flags = 0) {
    std::array<char, 65'536> piece{};
    const auto end = steady_clock::now() + milliseconds{20'000};
    while (received_.find(until) == std::string::npos && steady_clock::now() < end) {
      const ssize_t size = ::recv(socket_.get(), piece.data(), piece.size(), flags);
      if (size <= 0) break;
      received_.append(piece.data(), static_cast<std::size_t>(size));
    }
    return received_;
  }
  void end() const { ::shutdown(socket_.get(), SHUT_WR); }

 private:
  FileDescriptor socket_;
  std::string received_;
};

class Serve : public ::testing::Test {
 protected:
  void start(std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.begin(), {"serve", "--listen", "127.0.0.1:0", "--shm", segment(),
                                         "--socket", scratch_.path("status.sock").string()});
    server_ = std::make_unique<Child>(scratch_, "odom", arguments);
    std::smatch match;
    std::string errors;
    ASSERT_TRUE(eventually([&] {
      errors = server_->errors();
      return std::regex_search(errors, match, std::regex{"http://127.0.0.1:(\\d+)/"});
    })) << errors;
    port_ = std::stoi(match[1]);
  }
  void start_with_token() {
    const auto file = scratch_.write("token", std::string{token} + '\n');
    std::filesystem::permissions(file, std::filesystem::perms{0640});
    start({"--token-file", file.string()});
  }
  [[nodiscard]] std::string segment() const { return scratch_.path("pose").string(); }
  [[nodiscard]] std::string answer_to(const std::string& request) const {
    Client client{port_};
    client.send(request);
    return client.receive();
  }
  [[nodiscard]] std::string get(const std::string& path, const std::string& headers = "") const {
    return answer_to("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n");
  }
  /// The status of the answer: "401".
  [[nodiscard]] std::string code(const std::string& path, const std::string& headers = "") const {
    return get(path, headers).substr(9, 3);
  }
  [[nodiscard]] std::string stream_until(const std::string& part) const {
    Client client{port_};
    client.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client.receive(part);
  }
  /// Contents of /proc/PID/NAME of the server.
  [[nodiscard]] std::string proc(const std::string& name) const {
    return contents("/proc/" + std::to_string(server_->pid()) + '/' + name);
  }
  [[nodiscard]] long resident_kb() const {
    const std::string status = proc("status");
    return std::stol(status.substr(status.find("VmRSS:") + 6));
  }

  Scratch scratch_;
  std::unique_ptr<Child> server_;
  int port_ = 0;
};

}  // namespace odomd::tools
