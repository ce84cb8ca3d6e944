// Reads the machine from /etc, /proc and /sys.
#include <linux/capability.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <sstream>
#include <string_view>
#include <system_error>

#include "tools/doctor/doctor.hpp"

namespace odomd::tools::doctor {
namespace {

namespace fs = std::filesystem;

constexpr int highest_priority = 99;  // of SCHED_FIFO

// The first line; "" if the file cannot be read.
std::string line_of(const fs::path& file) {
  std::ifstream input(file);
  std::string line;
  std::getline(input, line);
  return line;
}

template <typename T>
std::optional<T> number_in(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  return value;
}

template <typename T>
T number_of(const fs::path& file, T otherwise) {
  return number_in<T>(line_of(file)).value_or(otherwise);
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code missing;
  for (fs::directory_iterator entry(folder, missing), end; !missing && entry != end;
       entry.increment(missing))
    entries.push_back(entry->path());
  std::ranges::sort(entries);
  return entries;
}

std::vector<std::string> words_of(const std::string& line, char between) {
  std::vector<std::string> words;
  std::istringstream input(line);
  for (std::string word; std::getline(input, word, between);)
    if (!word.empty()) words.push_back(word);
  return words;
}

// The text after `name` in a file with lines such as "Groups:\t4 24 27"; "" if no line has it.
std::string after(const fs::path& file, std::string_view name) {
  std::ifstream input(file);
  for (std::string line; std::getline(input, line);) {
    if (!line.starts_with(name)) continue;
    const std::size_t begin = line.find_first_not_of(" \t", name.size());
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return {};
}

// The fields of a line of /etc/passwd or /etc/group, found by name or number; empty if missing.
std::vector<std::string> account(const fs::path& file, std::size_t field, std::string_view value) {
  std::ifstream input(file);
  for (std::string line; std::getline(input, line);) {
    std::vector<std::string> fields;
    std::istringstream text(line);
    for (std::string one; std::getline(text, one, ':');) fields.push_back(one);
    if (fields.size() > std::max<std::size_t>(field, 2) && fields[field] == value) return fields;
  }
  return {};
}

struct Process {
  std::uint64_t capabilities = 0;
  std::string uid, gid;             // effective
  std::vector<std::string> groups;  // their numbers

  [[nodiscard]] bool has(unsigned capability) const {
    return (capabilities >> capability & 1U) != 0;
  }
};

Process read_process(const fs::path& root) {
  const fs::path status = root / "proc/self/status";
  Process process;
  constexpr int hexadecimal = 16;
  const std::string caps = after(status, "CapEff:");
  std::from_chars(caps.data(), caps.data() + caps.size(), process.capabilities, hexadecimal);
  const auto effective = [&](std::string_view name) {  // second of the four ids
    const auto ids = words_of(after(status, name), '\t');
    return ids.size() > 1 ? ids[1] : std::string{"0"};
  };
  process.uid = effective("Uid:");
  process.gid = effective("Gid:");
  process.groups = words_of(after(status, "Groups:"), ' ');
  process.groups.push_back(process.gid);
  return process;
}

// The hard limit, to which odomd (memlock) or the kernel raises the soft one.
std::string limit_of(const fs::path& root, std::string_view name) {
  const auto words = words_of(after(root / "proc/self/limits", name), ' ');
  return words.size() > 1 ? words[1] : std::string{};
}

void read_rights(const fs::path& root, const Process& process, Machine& machine) {
  const auto limit = limit_of(root, "Max realtime priority");
  machine.priority_limit = process.has(CAP_SYS_NICE) || limit == "unlimited"
                               ? highest_priority
                               : number_in<int>(limit).value_or(0);
  machine.may_lock_memory = process.has(CAP_IPC_LOCK) || process.has(CAP_SYS_RESOURCE) ||
                            limit_of(root, "Max locked memory") == "unlimited";
  machine.may_exceed_buffer = process.has(CAP_NET_ADMIN);

  const auto user = account(root / "etc/passwd", 2, process.uid);
  machine.user = user.empty() ? process.uid : user.front();
  const auto own = account(root / "etc/group", 2, process.gid);
  machine.group = own.empty() ? process.gid : own.front();
  for (const char* const folder : {"etc", "lib", "usr/lib", "usr/local/lib"}) {
    std::error_code missing;
    machine.has_service |= fs::exists(root / folder / "systemd/system/odomd@.service", missing);
  }
  const auto readers = account(root / "etc/group", 0, "odom");
  machine.has_service_accounts = !readers.empty() &&
                                 !account(root / "etc/group", 0, "odomd-camera").empty() &&
                                 !account(root / "etc/passwd", 0, "odomd").empty();
  if (readers.empty() || process.uid == "0") {
    machine.membership = Membership::not_needed;
  } else if (std::ranges::find(process.groups, readers[2]) != process.groups.end()) {
    machine.membership = Membership::member;
  } else {
    const auto members =
        readers.size() > 3 ? words_of(readers[3], ',') : std::vector<std::string>{};
    machine.membership = std::ranges::find(members, machine.user) != members.end()
                             ? Membership::later_login
                             : Membership::none;
  }
}

void read_sleep(const fs::path& root, Machine& machine) {
  for (const fs::path& state : entries_of(root / "sys/devices/system/cpu/cpu0/cpuidle"))
    if (number_of(state / "disable", 0) == 0)
      machine.deepest_sleep_us =
          std::max(machine.deepest_sleep_us, number_of(state / "latency", 0.0));
  const fs::path device = root / "dev/cpu_dma_latency";
  machine.may_hold_cpus_awake = ::access(device.c_str(), R_OK | W_OK) == 0;
  if (!machine.has_service) return;
  // The user of the service is in no other group.
  struct stat status {};
  const auto group = account(root / "etc/group", 0, "odomd");
  machine.may_hold_cpus_awake = ::stat(device.c_str(), &status) == 0 && group.size() > 2 &&
                                std::to_string(status.st_gid) == group[2] &&
                                (status.st_mode & S_IRGRP) != 0 && (status.st_mode & S_IWGRP) != 0;
}

void read_frequency(const fs::path& root, Machine& machine) {
  for (const fs::path& policy : entries_of(root / "sys/devices/system/cpu/cpufreq")) {
    const std::string governor = line_of(policy / "scaling_governor");
    if (governor.empty() || governor == "performance") continue;
    machine.governor = governor;
    return;
  }
}

}  // namespace

Machine read_machine(const fs::path& root) {
  Machine machine;
  machine.kernel = line_of(root / "proc/sys/kernel/osrelease");
  utsname names{};
  if (::uname(&names) == 0) machine.processor = std::data(names.machine);
  machine.is_realtime =
      number_of(root / "sys/kernel/realtime", 0) == 1 ||
      line_of(root / "proc/sys/kernel/version").find("PREEMPT_RT") != std::string::npos;
  read_rights(root, read_process(root), machine);
  read_sleep(root, machine);
  read_frequency(root, machine);
  const auto runtime = number_of(root / "proc/sys/kernel/sched_rt_runtime_us", -1.0);
  const auto period = number_of(root / "proc/sys/kernel/sched_rt_period_us", 1e6);
  machine.realtime_share = runtime < 0.0 ? 1.0 : runtime / period;  // -1: without limit
  machine.clock = line_of(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  machine.largest_buffer =
      number_of(root / "proc/sys/net/core/rmem_max", std::numeric_limits<std::int64_t>::max());
  std::error_code unknown;
  const fs::path here = fs::current_path(unknown);
  machine.folder = here.string();
  const fs::space_info space = fs::space(here, unknown);
  if (!unknown) machine.free_gb = static_cast<double>(space.available) / 1e9;
  return machine;
}

}  // namespace odomd::tools::doctor
