// A status socket of the tests' own: whoever connects is sent the text, as the daemon does.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "base/file_descriptor.hpp"

namespace odomd::tools {

/// Answers as long as it lives.
class AnsweringSocket {
 public:
  AnsweringSocket(const std::string& path, std::string text)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    if (::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(socket_.get(), 4) != 0) {
      throw std::runtime_error("cannot listen at " + path);
    }
    thread_ = std::thread{[this, text = std::move(text)] {
      while (true) {
        const int accepted = ::accept(socket_.get(), nullptr, nullptr);
        if (accepted < 0) return;  // shut down
        const FileDescriptor connection{accepted};
        (void)::send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL);
      }
    }};
  }
  ~AnsweringSocket() {
    ::shutdown(socket_.get(), SHUT_RDWR);
    thread_.join();
  }
  AnsweringSocket(const AnsweringSocket&) = delete;
  AnsweringSocket& operator=(const AnsweringSocket&) = delete;

 private:
  FileDescriptor socket_;
  std::thread thread_;
};

}  // namespace odomd::tools
