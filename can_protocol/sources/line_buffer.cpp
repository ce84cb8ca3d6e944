// The buffer moves its unread rest to the front before it reads more; nothing else is copied.
#include "can_protocol/sources/line_buffer.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace odomd::can {

std::optional<std::string_view> LineBuffer::next_line() noexcept {
  const char* const from = data_.get() + scanned_;
  const void* const newline = std::memchr(from, '\n', end_ - scanned_);
  if (newline == nullptr) {
    scanned_ = end_;
    if (begin_ == 0 && end_ == capacity) return last_line();
    return std::nullopt;
  }
  const auto length =
      static_cast<std::size_t>(static_cast<const char*>(newline) - (data_.get() + begin_));
  const std::string_view line(data_.get() + begin_, length);
  begin_ += length + 1;
  scanned_ = begin_;
  ++line_number_;
  return line;
}

std::optional<std::string_view> LineBuffer::last_line() noexcept {
  if (begin_ == end_) return std::nullopt;
  const std::string_view line(data_.get() + begin_, end_ - begin_);
  begin_ = scanned_ = end_;
  ++line_number_;
  return line;
}

LineBuffer::Fill LineBuffer::fill(int descriptor) noexcept {
  if (begin_ != 0) {
    std::memmove(data_.get(), data_.get() + begin_, end_ - begin_);
    end_ -= begin_;
    scanned_ -= begin_;
    begin_ = 0;
  }
  const ssize_t got = ::read(descriptor, data_.get() + end_, capacity - end_);
  if (got > 0) {
    end_ += static_cast<std::size_t>(got);
    return Fill::data;
  }
  if (got == 0) return Fill::end;
  return errno == EINTR || errno == EAGAIN ? Fill::again : Fill::error;
}

}  // namespace odomd::can
