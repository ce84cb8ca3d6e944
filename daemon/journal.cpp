#include "daemon/journal.hpp"

#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>

#include "daemon/error_sink.hpp"

namespace odomd::daemon {
namespace {

constexpr std::int64_t quiet_ns = 1'000'000'000;

std::shared_ptr<spdlog::sinks::sink> open_sink(const LogConfig& config) {
  if (config.file.empty()) {
    auto sink = std::make_shared<ErrorSink>();
    // systemd's journal knows the time and our name already.
    sink->set_pattern(std::getenv("JOURNAL_STREAM") != nullptr ? "%l: %v"
                                                               : "%H:%M:%S.%e odomd %l: %v");
    return sink;
  }
  auto sink = std::make_shared<spdlog::sinks::basic_file_sink_st>(config.file.string());
  sink->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z odomd[%P] %l: %v");
  return sink;
}

}  // namespace

Journal::Journal(const LogConfig& config) : config_(config) {
  try {
    logger_ = std::make_shared<spdlog::logger>("odomd", open_sink(config));
  } catch (const spdlog::spdlog_ex& error) {
    throw std::invalid_argument(
        fmt::format("[log] file {}: cannot be opened: {}", config.file.string(), error.what()));
  }
  logger_->set_level(spdlog::level::from_str(config.level));
  logger_->flush_on(spdlog::level::trace);
}

void Journal::reopen() {
  if (config_.file.empty()) return;
  try {
    logger_->sinks().front() = open_sink(config_);
    info("the log was opened anew");
  } catch (const spdlog::spdlog_ex& problem) {
    error(fmt::format("the log cannot be opened anew, the old one is kept: {}", problem.what()));
  }
}

void Journal::info(Topic topic, std::int64_t now_ns, const std::string& text) {
  limited(spdlog::level::info, topic, now_ns, text);
}

void Journal::warn(Topic topic, std::int64_t now_ns, const std::string& text) {
  limited(spdlog::level::warn, topic, now_ns, text);
}

void Journal::limited(spdlog::level::level_enum level, Topic topic, std::int64_t now_ns,
                      const std::string& text) {
  Limit& limit = limits_[static_cast<std::size_t>(topic)];
  if (limit.ever && now_ns - limit.last_ns < quiet_ns) {
    ++limit.kept_back;
    return;
  }
  if (limit.kept_back > 0) {
    logger_->log(level, "{} ({} more of this kind since the last)", text, limit.kept_back);
  } else {
    logger_->log(level, "{}", text);
  }
  limit = {now_ns, 0, true};
}

}  // namespace odomd::daemon
