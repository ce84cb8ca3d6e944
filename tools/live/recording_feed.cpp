#include "tools/live/recording_feed.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace odomd::tools {
namespace {

FileDescriptor connected(const std::string& path) {
  FileDescriptor connection = connect_to(path);
  if (!connection) fail_to_connect(path, errno, "record.sock");
  return connection;
}

FileDescriptor process_behind(const FileDescriptor& connection) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(connection.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return {};
  return FileDescriptor{static_cast<int>(::syscall(SYS_pidfd_open, peer.pid, 0))};
}

}  // namespace

RecordingFeed::RecordingFeed(const std::filesystem::path& socket)
    : name_(socket.string()), connection_(connected(name_)), daemon_(process_behind(connection_)) {}

bool RecordingFeed::is_daemon_running() const {
  constexpr int ending_ms = 500;
  pollfd end{daemon_.get(), POLLIN, 0};
  return daemon_ && ::poll(&end, 1, ending_ms) == 0;
}

std::optional<RecordingFeed::Message> RecordingFeed::buffered() {
  daemon::RecordingHeader header;
  if (buffer_.size() - at_ < sizeof header) return std::nullopt;
  std::memcpy(&header, buffer_.data() + at_, sizeof header);
  if (header.size > daemon::longest_recording_message ||
      header.kind > daemon::RecordingMessage::refused) {
    throw std::runtime_error(name_ + ": the data is not a recording; is odomd listening there?");
  }
  if (buffer_.size() - at_ - sizeof header < header.size) return std::nullopt;
  const Message message{header.kind,
                        std::string_view{buffer_}.substr(at_ + sizeof header, header.size)};
  at_ += sizeof header + header.size;
  return message;
}

std::optional<RecordingFeed::Message> RecordingFeed::next(std::chrono::milliseconds timeout) {
  while (true) {
    if (auto message = buffered()) return message;
    buffer_.erase(0, at_);
    at_ = 0;
    if (ended_) return std::nullopt;

    pollfd readable{connection_.get(), POLLIN, 0};
    const int ready = ::poll(&readable, 1, static_cast<int>(timeout.count()));
    if (ready <= 0) return std::nullopt;
    std::array<char, 1U << 16U> piece;
    const ssize_t size = ::recv(connection_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (size <= 0) {
      ended_ = true;
    } else {
      buffer_.append(piece.data(), static_cast<std::size_t>(size));
    }
  }
}

}  // namespace odomd::tools
