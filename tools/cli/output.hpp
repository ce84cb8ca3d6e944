// Standard output and standard error of the programs: what somebody has to read, and may not.
//
// Commands that end in their own way hold INT and TERM back (interrupt.hpp). A write to a pipe that
// nobody empties would hold them back for good: here it ends a second after the signal has come.
// And what goes through the streams is made harmless to terminals (base/printable.hpp).
#pragma once

#include <streambuf>
#include <string>
#include <string_view>

namespace odomd::tools {

/// Whether INT, TERM or HUP waits to be taken, and stays so: whoever asks leaves it pending.
[[nodiscard]] bool stop_is_asked();

/// Writes all of it, waiting for the reader. Returns 0, or what errno said; ECANCELED: a signal to
/// stop is pending and nothing could be written for a second.
[[nodiscard]] int write_all(int descriptor, std::string_view text);

/// In the words of a message, for ECANCELED too.
[[nodiscard]] std::string why_not_written(int error);

/// The buffer behind std::cout or std::cerr. Once it has failed it stays so; errno says why.
class OutputBuffer final : public std::streambuf {
 public:
  explicit OutputBuffer(int descriptor);

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override;

 private:
  int descriptor_;
  bool terminal_;
  int error_ = 0;
  std::string waiting_;
};

/// While it lives, std::cout and std::cerr write through OutputBuffers.
class StandardStreams {
 public:
  StandardStreams();
  ~StandardStreams();
  StandardStreams(const StandardStreams&) = delete;
  StandardStreams& operator=(const StandardStreams&) = delete;

 private:
  OutputBuffer out_;
  OutputBuffer error_;
  std::streambuf* out_before_;
  std::streambuf* error_before_;
};

/// One line on standard error, whatever the text holds: file names and the like may be part of it.
void say(std::string_view text);

/// Standard error as it is, with the characters that rewrite a line of a terminal.
void draw(std::string_view text);

}  // namespace odomd::tools
