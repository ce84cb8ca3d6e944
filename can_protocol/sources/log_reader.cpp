// Converts lines to frames; every error names the file, the line and the fix.
#include "can_protocol/sources/log_reader.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace odomd::can {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

void require_candump(const std::string& label, std::string_view start) {
  if (const auto format = describe_foreign_format(start)) throw LogError(label + ": " + *format);
}

}  // namespace

std::string log_label(const std::string& path) {
  return path == "-" ? "standard input" : path;
}

FileDescriptor open_log(const std::string& path, FifoOpening fifo) {
  if (path == "-") {
    FileDescriptor standard_input(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0));
    if (!standard_input) throw LogError("standard input is closed; pipe a candump log into it");
    return standard_input;
  }
  const int waiting = fifo == FifoOpening::non_blocking ? O_NONBLOCK : 0;
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | waiting));
  if (!file)
    throw LogError(path + ": " + reason(errno) + "; name a candump log (candump -L) to read");
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && S_ISDIR(status.st_mode))
    throw LogError(path + ": is a directory; name a candump log (candump -L) in it");
  if (S_ISREG(status.st_mode)) {
    std::array<char, 16384> start;
    const ssize_t size = ::pread(file.get(), start.data(), start.size(), 0);
    if (size > 0) require_candump(path, {start.data(), static_cast<std::size_t>(size)});
  }
  return file;
}

LogReader::LogReader(const std::string& path, BusNames& buses, Damage damage)
    : label_(log_label(path)), damage_(damage), file_(open_log(path)), lines_(label_, buses) {}

bool LogReader::take(std::string_view text, LineEnd end) {
  const LineKind kind = lines_.read(text, buffer_.line_number(), end, frame_);
  if (kind == LineKind::bus_too_many || (kind == LineKind::damaged && damage_ == Damage::refused))
    throw LogError(lines_.problem());
  return kind == LineKind::frame;
}

const Frame* LogReader::next() {
  while (!ended_) {
    if (const auto text = buffer_.next_line()) {
      if (take(*text, LineEnd::newline)) return &frame_;
      continue;
    }
    switch (buffer_.fill(file_.get())) {
      case LineBuffer::Fill::data:
        if (buffer_.line_number() == 0) require_candump(label_, buffer_.rest());
        break;
      case LineBuffer::Fill::again: {
        pollfd readable{file_.get(), POLLIN, 0};
        ::poll(&readable, 1, -1);
        break;
      }
      case LineBuffer::Fill::error:
        throw std::system_error(errno, std::generic_category(), label_ + ": reading failed");
      case LineBuffer::Fill::end: {
        ended_ = true;
        const auto text = buffer_.last_line();
        const bool taken = text && take(*text, LineEnd::end_of_log);
        if (lines_.frames() == 0)
          throw LogError(lines_.first_problem().empty()
                             ? label_ + ": contains no frame; a line of a candump log looks like " +
                                   std::string(candump_example)
                             : lines_.first_problem());
        if (taken) return &frame_;
      }
    }
  }
  return nullptr;
}

MergedLog::MergedLog(std::span<const std::string> paths, BusNames& buses, FrameSelection selected,
                     Damage damage)
    : selected_(std::move(selected)) {
  inputs_.reserve(paths.size());
  for (const std::string& path : paths)
    inputs_.push_back(
        {LogReader(path, buses, damage), LogStamps(log_label(path), LogStamps::Judging::offline)});
  for (Input& input : inputs_) input.head = read(input);
}

const LoggedFrame* MergedLog::read(Input& input) const {
  for (;;) {
    if (const LoggedFrame* const frame = input.stamps.next()) return frame;
    if (input.stamps.ended()) return nullptr;
    if (const Frame* const frame = input.reader.next()) {
      if (!selected_ || selected_(*frame)) input.stamps.add(*frame, input.reader.line_number());
      continue;
    }
    input.stamps.end();
    if (const std::string problem = input.stamps.describe_one_stamp(2); !problem.empty())
      throw LogError(problem);
  }
}

const Frame* MergedLog::next() {
  if (newest_ != nullptr) newest_->head = read(*newest_);
  Input* earliest = nullptr;
  for (Input& input : inputs_)
    if (input.head != nullptr &&
        (earliest == nullptr || input.head->frame.time_ns < earliest->head->frame.time_ns))
      earliest = &input;
  if (earliest == nullptr) return nullptr;
  newest_ = earliest;
  return &earliest->head->frame;
}

std::string MergedLog::position() const {
  if (newest_ == nullptr || newest_->head == nullptr) return {};
  return at_line(newest_->reader.label(), newest_->head->line);
}

std::vector<std::string> MergedLog::warnings() const {
  std::vector<std::string> all;
  for (const Input& input : inputs_) {
    const std::vector<std::string> lines = input.reader.warnings();
    all.insert(all.end(), lines.begin(), lines.end());
    if (std::string text = input.stamps.warning(); !text.empty()) all.push_back(std::move(text));
    if (input.stamps.frames() == 0)
      all.push_back(input.reader.label() + ": none of its " +
                    std::to_string(input.reader.frames()) +
                    " frames is of a mapped message; check that it is this car's log, and that "
                    "[can] dbc names this car's databases");
  }
  return all;
}

}  // namespace odomd::can
