#include "tools/tune/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::tools {
namespace {

constexpr std::chrono::milliseconds look_after{100};

/// What the threads share. One replay is a task: a drive of a trial.
struct Work {
  std::size_t tasks = 0;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};

  std::mutex mutex;  // of all below
  std::condition_variable changed;
  std::vector<TrialOutcome> outcomes;
  std::vector<std::size_t> left;  // drives of each trial that are not done
  std::vector<std::size_t> done;  // trials whose last drive is, in the order of their ends
  std::size_t replays = 0;
  std::size_t running = 0;
  std::exception_ptr failure;
};

bool is_as_configured(const Values& values) {
  return std::ranges::none_of(values, [](const auto& value) { return value.has_value(); });
}

struct Replayed {
  Score score{};
  std::string impossible;
};

Replayed replay_with(const TrialSettings& settings, const Drive& drive, const Values& values) {
  Replayed result;
  try {
    std::vector<ConfigValue> numbers;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i]) numbers.push_back({settings.parameters[i].key, *values[i], ""});
    daemon::Config config = config_with(drive, numbers);
    if (settings.model) config.model = *settings.model;
    result.score = score_of(evaluate_drive(drive, config, settings.measure));
  } catch (const std::invalid_argument& error) {
    if (is_as_configured(values)) throw;
    result.impossible = error.what();
  }
  return result;
}

void work_off(const TrialSettings& settings, std::span<const Values> trials, Work& work) {
  const std::size_t drives = settings.drives.size();
  while (!work.stop) {
    const std::size_t task = work.next++;
    if (task >= work.tasks) break;
    const std::size_t trial = task / drives;
    const std::size_t drive = task % drives;
    try {
      Replayed replayed = replay_with(settings, settings.drives[drive], trials[trial]);
      const std::scoped_lock lock(work.mutex);
      TrialOutcome& outcome = work.outcomes[trial];
      outcome.scores[drive] = replayed.score;
      if (!replayed.impossible.empty()) outcome.impossible = std::move(replayed.impossible);
      ++work.replays;
      if (--work.left[trial] == 0) {
        if (!outcome.impossible.empty()) outcome.scores.clear();
        work.done.push_back(trial);
      }
    } catch (...) {
      const std::scoped_lock lock(work.mutex);
      if (!work.failure) work.failure = std::current_exception();
      work.stop = true;
    }
    work.changed.notify_one();
  }
  const std::scoped_lock lock(work.mutex);
  --work.running;
  work.changed.notify_one();
}

/// The configuration's errors name a line of a generated text.
std::string without_place(const std::string& message, const std::filesystem::path& file) {
  const std::string place = file.string() + ':';
  if (!message.starts_with(place)) return message;
  const std::size_t after = message.find_first_not_of("0123456789: ", place.size());
  return after == std::string::npos ? message : message.substr(after);
}

/// Finds the option that is refused: one that is refused on its own.
daemon::Config parsed_with(const daemon::Config& own, std::span<const ConfigValue> patch) {
  try {
    return daemon::parse_config(patched(own.text, own.file, patch), own.file);
  } catch (const std::invalid_argument& error) {
    if (patch.empty()) throw;
    if (patch.size() > 1)
      for (std::size_t i = 0; i < patch.size(); ++i) (void)parsed_with(own, patch.subspan(i, 1));
    std::string options;
    for (const ConfigValue& set : patch)
      options += fmt::format("--set {}={}: ", set.key, set.value);
    throw std::invalid_argument(fmt::format(
        "{}{} ({})", options, without_place(error.what(), own.file), own.file.string()));
  }
}

}  // namespace

daemon::Config config_with(const Drive& drive, std::span<const ConfigValue> numbers) {
  const daemon::Config& own = drive.config;
  daemon::Config config = parsed_with(own, numbers);
  config.can.sources = own.can.sources;
  config.can.dbc = own.can.dbc;
  diagnostics::Diagnostics warnings;  // were given when the drive was read
  (void)daemon::load_databases(config, warnings);
  return config;
}

std::vector<TrialOutcome> run_trials(
    const TrialSettings& settings, std::span<const Values> trials, const Watch& watch,
    const std::function<void(std::size_t trial, const TrialOutcome&)>& finished) {
  Work work;
  work.tasks = trials.size() * settings.drives.size();
  work.outcomes.assign(trials.size(),
                       {.scores = std::vector<Score>(settings.drives.size()), .impossible = ""});
  work.left.assign(trials.size(), settings.drives.size());
  work.running = std::min(std::max<std::size_t>(settings.threads, 1), work.tasks);

  std::vector<std::jthread> threads;
  for (std::size_t i = 0, count = work.running; i < count; ++i)
    threads.emplace_back([&] { work_off(settings, trials, work); });

  std::size_t reported = 0;
  bool stopped = false;
  std::unique_lock lock(work.mutex);
  while (work.running > 0 || reported < work.done.size()) {
    if (reported == work.done.size()) work.changed.wait_for(lock, look_after);
    for (; reported < work.done.size(); ++reported)
      finished(work.done[reported], work.outcomes[work.done[reported]]);
    if (watch(work.replays, work.tasks) == GoOn::no) {
      stopped = true;
      work.stop = true;
    }
  }
  lock.unlock();
  threads.clear();
  if (work.failure) std::rethrow_exception(work.failure);
  if (stopped) throw Stopped("stopped");
  return std::move(work.outcomes);
}

}  // namespace odomd::tools
