#include "daemon/journal/journal.hpp"

#include <poll.h>
#include <sys/stat.h>
#include <syslog.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>

#include "base/input_file.hpp"
#include "daemon/journal/error_sink.hpp"

namespace odomd::daemon {
namespace {

/// The level as a syslog priority, which the journal reads from the head of a line.
class SyslogLevel final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    // In the order of spdlog's levels, from trace to critical.
    static constexpr std::array priorities{LOG_DEBUG,   LOG_DEBUG, LOG_INFO,
                                           LOG_WARNING, LOG_ERR,   LOG_CRIT};
    fmt::format_to(std::back_inserter(line), "<{}>",
                   priorities.at(static_cast<std::size_t>(message.level)));
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<SyslogLevel>();
  }
};

/// Whether standard error goes to systemd's journal. The variable alone may be inherited from a
/// parent.
bool writes_to_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat error {};
  return stream != nullptr && ::fstat(STDERR_FILENO, &error) == 0 &&
         fmt::format("{}:{}", error.st_dev, error.st_ino) == stream;
}

constexpr auto terminal_pattern = "%H:%M:%S.%e odomd %l: %v";

std::shared_ptr<spdlog::sinks::sink> open_sink(const LogConfig& config) {
  if (config.file.empty()) {
    auto sink = std::make_shared<ErrorSink>();
    if (writes_to_journal()) {  // the journal adds the time and our name
      auto formatter = std::make_unique<spdlog::pattern_formatter>();
      formatter->add_flag<SyslogLevel>('*').set_pattern("%*%l: %v");
      sink->set_formatter(std::move(formatter));
    } else {
      sink->set_pattern(terminal_pattern);
    }
    return sink;
  }
  if (const std::string_view kind = kind_of_no_file(config.file); !kind.empty())
    throw spdlog::spdlog_ex(
        fmt::format("is {}; name a file, or remove the key to log to standard error", kind));
  auto sink = std::make_shared<spdlog::sinks::basic_file_sink_st>(config.file.string());
  sink->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z odomd[%P] %l: %v");
  return sink;
}

}  // namespace

void ErrorSink::sink_it_(const spdlog::details::log_msg& message) {
  // A descriptor that is ready takes PIPE_BUF bytes without blocking.
  pollfd room{descriptor_, POLLOUT, 0};
  if (::poll(&room, 1, 0) == 0) {
    ++lost_;
    return;
  }
  std::string text;
  if (lost_ > 0) text = fmt::format("({} lines lost: standard error was not read)\n", lost_);
  spdlog::memory_buf_t line;
  formatter_->format(message, line);
  text.append(line.data(), line.size());
  if (text.size() > PIPE_BUF) {
    text.resize(PIPE_BUF);
    text.back() = '\n';
  }
  while (::write(descriptor_, text.data(), text.size()) < 0 && errno == EINTR) {
  }
  lost_ = 0;  // if writing failed, the failure cannot be reported
}

Journal::Journal(const LogConfig& config) : config_(config) {
  try {
    logger_ = std::make_shared<spdlog::logger>("odomd", open_sink(config));
  } catch (const spdlog::spdlog_ex& error) {
    throw std::invalid_argument(
        fmt::format("[log] file {}: cannot be opened: {}", config.file.string(), error.what()));
  }
  logger_->set_level(spdlog::level::from_str(config.level));
  logger_->flush_on(spdlog::level::trace);
  logger_->set_error_handler([this](const std::string& what) { report_unwritten(what); });
}

void Journal::report_unwritten(const std::string& what) {
  const Message message{spdlog::level::err,
                        fmt::format("{}: messages are lost: {}; make room, or correct [log] file",
                                    config_.file.string(), what)};
  if (!repeats_.take(message, now_ns_)) return;
  ErrorSink terminal;
  terminal.set_pattern(terminal_pattern);
  terminal.log({"odomd", message.level, one_line(message.text)});
}

void Journal::reopen() {
  if (config_.file.empty()) return;
  try {
    logger_->sinks().front() = open_sink(config_);
    info("the log was reopened");
  } catch (const spdlog::spdlog_ex& problem) {
    error(fmt::format("the log cannot be reopened, keeping the old one: {}", problem.what()));
  }
}

void Journal::turn(std::int64_t now_ns) {
  now_ns_ = now_ns;
  for (const Message& message : repeats_.due(now_ns)) write(message);
}

Journal::~Journal() {
  try {
    for (const Message& message : repeats_.rest(now_ns_)) write(message);
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): there is no log to write it to
  }
}

void Journal::count(spdlog::level::level_enum level, const std::string& text) {
  const Message message{level, one_line(text)};
  if (repeats_.take(message, now_ns_)) write(message);
}

}  // namespace odomd::daemon
