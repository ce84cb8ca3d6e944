// A terminal in full-screen mode, restored however the program ends, and the keys pressed on it.
#pragma once

#include <termios.h>

#include <chrono>
#include <csignal>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file_descriptor.hpp"
#include "tools/live/line.hpp"

namespace odomd::tools::watch {

enum class Key { quit, pause, up, down, page_up, page_down };

/// The keys in one read; other keys and unknown sequences are skipped.
[[nodiscard]] std::vector<Key> keys_in(std::string_view bytes);

/// Events that wait() saw. `ended`: INT, TERM or HUP has come, or the terminal is gone.
struct Happened {
  std::vector<Key> keys;
  bool ended = false;
};

/// Standard output as a screen: its alternate page, without echo and cursor, while this lives. TSTP
/// gives the terminal back until the process continues. One at a time, in a process of one thread.
class Terminal {
 public:
  /// Throws std::runtime_error if the terminal cannot be configured.
  explicit Terminal(Colour colour);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Columns and rows.
  [[nodiscard]] static std::pair<std::size_t, std::size_t> size();

  /// Shows a screenful; only lines that have changed are written.
  void show(const Lines& lines);

  /// Sleeps until a key is pressed, the size changes, the program must end, or the time is up.
  [[nodiscard]] Happened wait(std::chrono::steady_clock::time_point until);

 private:
  void enter();
  void leave();

  Colour colour_;
  bool keyboard_ = false;  // standard input is a terminal too
  termios before_{};
  sigset_t signals_before_{};
  FileDescriptor signals_;
  std::vector<std::string> shown_;  // the lines on the screen
};

/// Whether standard output is a terminal that can be drawn upon, not a dumb one.
[[nodiscard]] bool is_screen();

/// Follows NO_COLOR (see no-color.org).
[[nodiscard]] Colour colour_wanted();

}  // namespace odomd::tools::watch
