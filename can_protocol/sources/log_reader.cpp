// Converts lines to frames; every error names the file, the line and the fix.
#include "can_protocol/sources/log_reader.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace odomd::can {
namespace {

constexpr std::string_view example = "(1760000000.069964) can0 120#0400A0FF";

std::string reason(int error) {
  return std::generic_category().message(error);
}

}  // namespace

std::string at_line(const std::string& label, std::uint64_t line_number) {
  return label + ":" + std::to_string(line_number) + ": ";
}

bool is_blank(std::string_view line) noexcept {
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

std::string log_label(const std::string& path) {
  return path == "-" ? "standard input" : path;
}

FileDescriptor open_log(const std::string& path, FifoOpening fifo) {
  if (path == "-") {
    FileDescriptor standard_input(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0));
    if (!standard_input) throw LogError("standard input is closed; pipe a candump log into it");
    return standard_input;
  }
  const int waiting = fifo == FifoOpening::at_once ? O_NONBLOCK : 0;
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | waiting));
  if (!file)
    throw LogError(path + ": " + reason(errno) + "; name a candump log (candump -L) to read");
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && S_ISDIR(status.st_mode))
    throw LogError(path + ": is a directory; name a candump log (candump -L) in it");
  return file;
}

std::string describe(const std::string& label, std::uint64_t line_number, const CandumpLine& line) {
  return at_line(label, line_number) + "expected " + std::string(line.expected) + " at column " +
         std::to_string(line.column) + "; a line looks like " + std::string(example);
}

std::string describe_cut_off(const std::string& label, std::uint64_t line_number) {
  return at_line(label, line_number) + "the last line is cut off and is ignored";
}

std::string describe_bus_too_many(const std::string& label, std::uint64_t line_number,
                                  std::string_view interface) {
  return at_line(label, line_number) + "\"" + std::string(interface) +
         "\" is one bus too many; odomd reads at most " + std::to_string(max_buses) +
         " buses: remove the others from the log";
}

std::string describe_one_stamp(const std::string& position, std::uint64_t frames,
                               std::int64_t stamp_ns) {
  const std::string s = std::to_string(stamp_ns / 1'000'000'000);
  const std::string us = std::to_string(1'000'000 + stamp_ns / 1000 % 1'000'000).substr(1);
  return position + "all " + std::to_string(frames) + " frames so far have the time stamp " + s +
         "." + us + (stamp_ns == 0 ? ", which means no time" : "") +
         ": no time passes between them; record with candump -L, which stamps every frame";
}

LogReader::LogReader(const std::string& path, BusNames& buses)
    : label_(log_label(path)), buses_(buses), file_(open_log(path)) {}

bool LogReader::take(std::string_view text, Ending ending) {
  if (is_blank(text)) return false;
  const CandumpLine line = parse_candump_line(text);
  if (!line.good()) {
    // A file whose only line is not a frame is not a truncated log.
    if (ending == Ending::newline || frames_ == 0)
      throw LogError(describe(label_, lines_.line_number(), line));
    warning_ = describe_cut_off(label_, lines_.line_number());
    return false;
  }
  if (line.interface != last_interface_) {
    const auto bus = buses_.index_of(line.interface);
    if (!bus) throw LogError(describe_bus_too_many(label_, lines_.line_number(), line.interface));
    last_interface_ = line.interface;
    last_bus_ = *bus;
  }
  frame_ = line.frame;
  frame_.bus = last_bus_;
  ++frames_;
  return true;
}

const Frame* LogReader::next() {
  while (!ended_) {
    if (const auto text = lines_.next_line()) {
      if (take(*text, Ending::newline)) return &frame_;
      continue;
    }
    switch (lines_.fill(file_.get())) {
      case LineBuffer::Fill::data:
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
        const auto text = lines_.last_line();
        const bool taken = text && take(*text, Ending::cut_off);
        if (frames_ == 0)
          throw LogError(label_ + ": contains no frame; a line of a candump log looks like " +
                         std::string(example));
        if (taken) return &frame_;
      }
    }
  }
  return nullptr;
}

MergedLog::MergedLog(std::span<const std::string> paths, BusNames& buses) {
  inputs_.reserve(paths.size());
  for (const std::string& path : paths) inputs_.push_back({LogReader(path, buses)});
  for (Input& input : inputs_) input.head = input.reader.next();
}

const Frame* MergedLog::next() {
  if (newest_ != nullptr) newest_->head = newest_->reader.next();
  Input* earliest = nullptr;
  for (Input& input : inputs_)
    if (input.head != nullptr &&
        (earliest == nullptr || input.head->time_ns < earliest->head->time_ns))
      earliest = &input;
  if (earliest == nullptr) return nullptr;
  newest_ = earliest;
  return earliest->head;
}

std::string MergedLog::position() const {
  return newest_ == nullptr ? std::string{}
                            : at_line(newest_->reader.label(), newest_->reader.line_number());
}

std::vector<std::string> MergedLog::warnings() const {
  std::vector<std::string> all;
  for (const Input& input : inputs_)
    if (!input.reader.warning().empty()) all.push_back(input.reader.warning());
  return all;
}

}  // namespace odomd::can
