// Mistakes of the machine, made in values and in copies of /etc, /proc and /sys.
#include "tools/doctor/doctor.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::doctor::machine_test {
namespace {

using diagnostics::Named;

using Found = ::testing::Matcher<const diagnostics::Diagnostics&>;

TEST(Machine, GetsTheFixOfEachMistake) {
  const std::pair<Machine, Found> cases[]{
      {{}, IsEmpty()},
      {{.is_realtime = false},
       ElementsAre(Named("no_realtime_kernel", "6.1.0-rt",
                         HasSubstr("sudo apt install linux-image-rt-amd64")))},
      {{.processor = "aarch64", .is_realtime = false},
       ElementsAre(Named("no_realtime_kernel", "6.1.0-rt", HasSubstr("linux-image-rt-arm64")))},
      {{.user = "ada", .priority_limit = 0, .may_lock_memory = false},
       ElementsAre(Named("no_realtime_priority", "45", HasSubstr("\"ada - rtprio 45\"")),
                   Named("memory_not_locked", "", HasSubstr("\"ada - memlock unlimited\"")))},
      // The CPUs sleep deeply.
      {{.may_hold_cpus_awake = false}, IsEmpty()},
      {{.group = "ada", .may_hold_cpus_awake = false, .deepest_sleep_us = 350.0},
       ElementsAre(Named("cpus_sleep_deeply", "350", HasSubstr("chgrp ada /dev/cpu_dma_latency")))},
      {{.group = "ada",
        .has_service = true,
        .may_hold_cpus_awake = false,
        .deepest_sleep_us = 350.0},
       ElementsAre(
           Named("cpus_sleep_deeply", "350", HasSubstr("chgrp odomd /dev/cpu_dma_latency")))},
      {{.has_service = true, .deepest_sleep_us = 350.0}, IsEmpty()},
      // Real-time threads are throttled, or the clock or CPU frequency is slow.
      {{.realtime_share = 0.1, .clock = "hpet", .governor = "powersave"},
       ElementsAre(
           Named("realtime_throttled", "10 %", "sudo sysctl kernel.sched_rt_runtime_us=950000"),
           Named("slow_clock", "hpet", HasSubstr("echo tsc | sudo tee")),
           Named("cpu_frequency_changes", "powersave",
                 HasSubstr("cpupower frequency-set -g performance")))},
      {{.clock = "kvm-clock"}, IsEmpty()},
      {{.clock = "arch_sys_counter"}, IsEmpty()},
      {{.clock = ""}, IsEmpty()},
      // A service lacks the capability to exceed the limit of receive buffers.
      {{.largest_buffer = 212'992},
       ElementsAre(
           Named("small_receive_buffer", "212992", HasSubstr("net.core.rmem_max=1048576")))},
      {{.may_exceed_buffer = true, .largest_buffer = 212'992}, IsEmpty()},
      {{.has_service = true, .may_exceed_buffer = true, .largest_buffer = 212'992},
       ElementsAre(Named("small_receive_buffer"))},
      // The user is not in the service's group; without a service, no account is required.
      {{.user = "ada", .membership = Membership::none},
       ElementsAre(Named("not_in_group", "ada", HasSubstr("sudo usermod -aG odom ada")))},
      {{.user = "ada", .membership = Membership::later_login},
       ElementsAre(Named("login_before_group", "ada"))},
      {{.has_service_accounts = false, .membership = Membership::not_needed}, IsEmpty()},
      {{.has_service = true, .has_service_accounts = false, .membership = Membership::not_needed},
       ElementsAre(Named("service_account_missing"))},
      {{.folder = "/drives", .free_gb = 0.3},
       ElementsAre(Named("disk_nearly_full", "/drives: 0.30 GB"))}};
  for (std::size_t i = 0; i < std::size(cases); ++i)
    EXPECT_THAT(examine_machine(cases[i].first), cases[i].second) << "case " << i;
}

TEST(Machine, LimitsOfTheUserDoNotMatterToAServiceNorToARunningDaemon) {
  Machine machine{.priority_limit = 0, .may_lock_memory = false};
  EXPECT_THAT(examine_machine(machine, {.is_granted = true}), IsEmpty());
  machine.has_service = true;
  EXPECT_THAT(examine_machine(machine), IsEmpty());
  const Machine enough{.priority_limit = 45};
  EXPECT_THAT(examine_machine(enough), IsEmpty());
  EXPECT_THAT(examine_machine(enough, {.priority = 46}),
              ElementsAre(Named("no_realtime_priority", "46")));
}

// A machine in files, without mistakes: user 1000 is in the group odom, and the service is
// installed.
class Files {
 public:
  Files() {
    write("proc/sys/kernel/osrelease", "6.1.0-28-rt-amd64\n");
    write("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.119-1\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    write("proc/sys/net/core/rmem_max", "1048576\n");
    process("44 990 ");
    write("proc/self/limits",
          "Limit                     Soft Limit           Hard Limit           Units     \n"
          "Max locked memory         8388608              8388608              bytes     \n"
          "Max realtime priority     0                    0                    \n");
    write("etc/passwd",
          "root:x:0:0::/root:/bin/bash\nada:x:1000:1000:Ada,,,:/home/ada:/bin/bash\n"
          "odomd:x:991:991::/:/usr/sbin/nologin\n");
    write("etc/group", "root:x:0:\nada:x:1000:\nodom:x:990:ada\nodomd-camera:x:989:\nodomd:x:" +
                           std::to_string(::getgid()) + ":\n");
    write("usr/lib/systemd/system/odomd@.service", "");
    write("dev/cpu_dma_latency", "");
    ::chmod(path("dev/cpu_dma_latency").c_str(), 0660);
    write("sys/devices/system/cpu/cpu0/cpuidle/state0/latency", "2\n");
    write("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "400\n");
    write("sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "performance\n");
    write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
  }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const {
    return scratch_.path(name);
  }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(path(name).parent_path());
    scratch_.write(name, text);
  }
  void process(const std::string& groups) const {
    write("proc/self/status",
          "Name:\todom\nUid:\t1000\t1000\t1000\t1000\n"
          "Gid:\t1000\t1000\t1000\t1000\nGroups:\t" +
              groups + "\nCapEff:\t0000000000000000\n");
  }
  [[nodiscard]] Machine read() const {
    Machine machine = read_machine(scratch_.path(""));
    machine.free_gb = 100.0;  // of the real disk
    return machine;
  }

 private:
  Scratch scratch_;
};

TEST(Files, OfASoundMachineGiveNothing) {
  const Machine machine = Files{}.read();
  EXPECT_EQ(machine.kernel, "6.1.0-28-rt-amd64");
  EXPECT_EQ(machine.user, "ada");
  EXPECT_EQ(machine.deepest_sleep_us, 400.0);
  EXPECT_EQ(machine.membership, Membership::member);
  EXPECT_FALSE(machine.may_lock_memory);
  EXPECT_THAT(examine_machine(machine), IsEmpty());
}

TEST(Files, ShowEveryMistakeOfAMachine) {
  const Files files;
  files.write("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.119-1\n");
  files.write("proc/sys/kernel/sched_rt_runtime_us", "100000\n");
  files.write("proc/sys/net/core/rmem_max", "212992\n");
  files.write("sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "schedutil\n");
  files.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "acpi_pm\n");
  files.process("44");
  ::chmod(files.path("dev/cpu_dma_latency").c_str(), 0600);
  EXPECT_THAT(
      examine_machine(files.read()),
      ElementsAre(Named("no_realtime_kernel"), Named("login_before_group", "ada"),
                  Named("cpus_sleep_deeply"), Named("realtime_throttled"), Named("slow_clock"),
                  Named("cpu_frequency_changes"), Named("small_receive_buffer")));
}

TEST(Files, WithoutTheServiceShowTheUsersOwnLimits) {
  const Files files;
  std::filesystem::remove(files.path("usr/lib/systemd/system/odomd@.service"));
  EXPECT_THAT(examine_machine(files.read()),
              ElementsAre(Named("no_realtime_priority"), Named("memory_not_locked")));
  files.write("proc/self/limits",
              "Max locked memory         unlimited            unlimited            bytes     \n"
              "Max realtime priority     49                   49                   \n");
  EXPECT_THAT(examine_machine(files.read()), IsEmpty());
}

TEST(Files, ThatAreMissingAreNoFault) {
  const Scratch empty;
  Machine machine = read_machine(empty.path(""));
  machine.free_gb = 100.0;
  machine.priority_limit = 99;
  machine.may_lock_memory = true;
  EXPECT_THAT(examine_machine(machine), ElementsAre(Named("no_realtime_kernel")));
}

}  // namespace
}  // namespace odomd::tools::doctor::machine_test
