// Lines out of a file descriptor, in one fixed buffer: what a log file and a pipe have in common.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

namespace odomd::can {

/// Does not own the descriptor. One thread.
class LineBuffer {
 public:
  /// A line longer than this is no log: it comes out in pieces of this size.
  static constexpr std::size_t capacity = std::size_t{1} << 17U;

  enum class Fill : std::uint8_t { data, end, again, error };

  /// The next whole line without its newline; nothing when there is none in the buffer. The view
  /// holds until the next fill.
  [[nodiscard]] std::optional<std::string_view> next_line() noexcept;

  /// Once the input has ended: what stands after the last newline, if anything does.
  [[nodiscard]] std::optional<std::string_view> last_line() noexcept;

  /// Reads once. `error` leaves errno as read(2) set it; `again`: nothing there yet.
  Fill fill(int descriptor) noexcept;

  /// Of the line that came last, 1-based.
  [[nodiscard]] std::uint64_t line_number() const noexcept { return line_number_; }

 private:
  std::unique_ptr<char[]> data_ = std::make_unique<char[]>(capacity);
  std::size_t begin_ = 0;
  std::size_t scanned_ = 0;  // no newline in [begin_, scanned_)
  std::size_t end_ = 0;
  std::uint64_t line_number_ = 0;
};

}  // namespace odomd::can
