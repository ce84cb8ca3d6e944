#include "tools/tune/trial_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "tools/cli/files.hpp"
#include "tools/cli/json_text.hpp"

namespace odomd::tools {
namespace {

using nlohmann::ordered_json;

std::string header_of(std::span<const Parameter> parameters,
                      const std::vector<std::string>& drives) {
  ordered_json header{{"odom_tune", 1}, {"keys", ordered_json::array()}, {"drives", drives}};
  for (const Parameter& parameter : parameters) header["keys"].push_back(parameter.key);
  return json_text(header);
}

/// NaN, which JSON does not know, is null.
std::string line_of(const Values& values, const TrialOutcome& outcome) {
  ordered_json line{{"values", ordered_json::array()}, {"scores", ordered_json::array()}};
  for (const auto& value : values)
    line["values"].push_back(value ? ordered_json(*value) : ordered_json());
  for (const Score& score : outcome.scores) line["scores"].push_back(score);
  if (!outcome.impossible.empty()) line["impossible"] = outcome.impossible;
  return json_text(line);
}

Score score_from(const ordered_json& json) {
  Score score;
  for (std::size_t i = 0; i < score.size(); ++i)
    score[i] =
        json.at(i).is_null() ? std::numeric_limits<double>::quiet_NaN() : json.at(i).get<double>();
  return score;
}

bool same_bits(const Score& one, const Score& other) {
  for (std::size_t i = 0; i < one.size(); ++i) {
    const bool both_unknown = std::isnan(one[i]) && std::isnan(other[i]);
    if (!both_unknown && one[i] != other[i]) return false;
  }
  return true;
}

// Two runs that write into one file would each go on from a part of it.
FileDescriptor locked(const std::filesystem::path& file) {
  constexpr mode_t permissions = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;
  FileDescriptor lock(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, permissions));
  if (!lock)
    throw std::invalid_argument(
        fmt::format("{}: cannot be read and written: {}; give another --state", file.string(),
                    std::generic_category().message(errno)));
  // A file system without locks does without.
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw std::invalid_argument(file.string() +
                                ": another odom tune is using it; wait for its end, or give "
                                "another --state");
  return lock;
}

}  // namespace

TrialLog::TrialLog(std::filesystem::path file, std::span<const Parameter> parameters,
                   const std::vector<std::string>& drives)
    : file_(std::move(file)), header_(header_of(parameters, drives)) {
  if (file_.empty()) return;
  lock_ = locked(file_);
  std::ostringstream all;
  all << open_input(file_).rdbuf();
  const std::string text = all.str();
  std::size_t number = 0;
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; (end = text.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    take_line(text.substr(begin, end - begin), ++number);
    kept = end + 1;
  }
  if (kept == 0 && !text.empty()) take_line(text, 1);  // no line of ours: says so
  read_ = outcomes_.size();

  if (kept < text.size()) std::filesystem::resize_file(file_, kept);
  output_.open(file_, std::ios::app | std::ios::binary);
  if (!output_) (void)open_output(file_);  // says why
  if (number == 0) output_ << header_ << '\n' << std::flush;
}

void TrialLog::take_line(const std::string& line, std::size_t number) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("{}:{}: {}; give another --state, or remove the file",
                                            file_.string(), number, why));
  };
  if (number == 1) {
    if (line == header_) return;
    refuse(line.starts_with("{\"odom_tune\":1,") ? "has other keys or drives than this command"
                                                 : "is not a state file of odom tune");
  }
  if (is_nested_too_deep(line)) refuse("is damaged");
  try {
    const ordered_json json = ordered_json::parse(line);
    TrialOutcome outcome;
    for (const ordered_json& score : json.at("scores")) outcome.scores.push_back(score_from(score));
    if (json.contains("impossible")) outcome.impossible = json.at("impossible");
    Values values;
    for (const ordered_json& value : json.at("values"))
      values.push_back(value.is_null() ? std::nullopt : std::optional(value.get<double>()));
    outcomes_.insert_or_assign(std::move(values), std::move(outcome));
  } catch (const ordered_json::exception&) {
    refuse("is damaged");
  }
}

const TrialOutcome* TrialLog::find(const Values& values) const {
  const auto found = outcomes_.find(values);
  return found == outcomes_.end() ? nullptr : &found->second;
}

void TrialLog::add(const Values& values, const TrialOutcome& outcome) {
  outcomes_.insert_or_assign(values, outcome);
  if (file_.empty()) return;
  output_ << line_of(values, outcome) << '\n' << std::flush;
  if (!output_) throw std::runtime_error(file_.string() + ": cannot be written; is the disk full?");
}

void TrialLog::check_unchanged(const Values& as_configured, const TrialOutcome& as_it_is) const {
  const TrialOutcome* then = find(as_configured);
  if (then == nullptr) return;
  bool same = then->scores.size() == as_it_is.scores.size();
  for (std::size_t i = 0; same && i < as_it_is.scores.size(); ++i)
    same = same_bits(then->scores[i], as_it_is.scores[i]);
  if (!same) {
    throw std::invalid_argument(file_.string() +
                                ": the present configuration gives other errors than when this was "
                                "written: a drive, the configuration, an option or odom itself has "
                                "changed; give another --state, or remove the file");
  }
}

}  // namespace odomd::tools
