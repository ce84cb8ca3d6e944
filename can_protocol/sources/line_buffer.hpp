// Reads lines from a file descriptor (a log file or a pipe) through one fixed buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

namespace odomd::can {

/// Does not own the descriptor. For use by one thread.
class LineBuffer {
 public:
  /// The maximum length of a line; a longer one is returned in pieces of this size.
  static constexpr std::size_t capacity = std::size_t{1} << 17U;

  enum class Fill : std::uint8_t { data, end, again, error };

  /// The next complete line without its newline; empty when the buffer has none. The view is valid
  /// until the next fill.
  [[nodiscard]] std::optional<std::string_view> next_line() noexcept;

  /// After the end of the input: the text after the last newline, if any.
  [[nodiscard]] std::optional<std::string_view> last_line() noexcept;

  /// Reads once. `error` leaves errno as read(2) set it; `again`: no data yet.
  Fill fill(int descriptor) noexcept;

  /// The text that has been read and not yet returned; valid until the next fill.
  [[nodiscard]] std::string_view rest() const noexcept {
    return {data_.get() + begin_, end_ - begin_};
  }

  /// The number of the line that was returned last, 1-based.
  [[nodiscard]] std::uint64_t line_number() const noexcept { return line_number_; }

 private:
  std::unique_ptr<char[]> data_ = std::make_unique<char[]>(capacity);
  std::size_t begin_ = 0;
  std::size_t scanned_ = 0;  // no newline in [begin_, scanned_)
  std::size_t end_ = 0;
  std::uint64_t line_number_ = 0;
};

}  // namespace odomd::can
