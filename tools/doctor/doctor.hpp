// Examines what odom doctor looks at: the machine that odomd runs on or will run on, a running
// daemon by its status, CAN buses, and drives.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/controller.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

// The machine: causes of late ticks, and the right to read the pose; and a running daemon.

/// The user's membership in the group that may read the service's pose.
enum class Membership : std::uint8_t {
  not_needed,   ///< there is no such group, or the user is root
  member,       ///< this login is in the group
  later_login,  ///< the user is in the group, but this login is older
  none,
};

/// The machine as read by read_machine(); the defaults are those of a sound machine.
struct Machine {
  std::string kernel = "6.1.0-rt";  ///< its release
  std::string processor = "x86_64";
  bool is_realtime = true;  ///< PREEMPT_RT
  std::string user = "user";
  std::string group = "user";        ///< the user's primary group
  bool has_service = false;          ///< odomd@.service is installed
  bool has_service_accounts = true;  ///< the service's user and groups exist
  Membership membership = Membership::member;
  int priority_limit = 99;                ///< highest SCHED_FIFO priority of this process
  bool may_lock_memory = true;            ///< this process, without limit
  bool may_hold_cpus_awake = true;        ///< this process; with a service: the service's group
  double deepest_sleep_us = 0.0;          ///< wake-up latency of the deepest sleep state in use
  double realtime_share = 0.95;           ///< share of the time for real-time threads
  std::string clock = "tsc";              ///< the kernel's clock source
  std::string governor;                   ///< of a CPU that changes its frequency; empty: none
  bool may_exceed_buffer = false;         ///< CAP_NET_ADMIN
  std::int64_t largest_buffer = 1 << 20;  ///< net.core.rmem_max
  std::string folder = ".";
  double free_gb = 100.0;  ///< free space in `folder`
};

/// `root` is "/", or in tests a folder with copies of /etc, /proc and /sys. Missing entries are no
/// fault: a machine without cpufreq has no governor.
[[nodiscard]] Machine read_machine(const std::filesystem::path& root = "/");

/// odomd's requirements on the machine.
struct Needs {
  int priority = daemon::RealtimeConfig{}.priority;
  int receive_buffer = daemon::CanConfig{}.receive_buffer;
  bool is_granted = false;  ///< a daemon runs, whose status reports its rights
};

[[nodiscard]] diagnostics::Diagnostics examine_machine(const Machine& machine,
                                                       const Needs& needs = {});

/// Examines a running daemon: rights that the machine refused, its beat, buses, sources and camera.
/// `status` is the document of the status socket; `machine` has the user whose limits to raise.
/// Causes are reported without their consequences: a beat without real-time priority is not called
/// late, a signal of a silent bus not overdue. examine_link() examines the interfaces.
/// Throws a nlohmann::json::exception if a member has the wrong type.
[[nodiscard]] diagnostics::Diagnostics examine_daemon(const nlohmann::json& status,
                                                      const Machine& machine);

// CAN buses: whether an interface can receive the car's frames, and whether its traffic matches
// the configuration and the databases.

/// A network interface.
struct Link {
  bool is_can = true;
  bool is_up = true;
  bool carries_fd = false;                    ///< CAN FD frames
  std::optional<can::Controller> controller;  ///< none: a virtual interface
};

/// Nothing if there is no such interface. Not thread-safe, like can::read_controller().
[[nodiscard]] std::optional<Link> read_link(const std::string& interface);

/// CAN FD if a mapped message needs it.
[[nodiscard]] can::FrameProtocol needed_protocol(const daemon::Config& config,
                                                 std::span<const can::Database> databases);

[[nodiscard]] diagnostics::Diagnostics examine_link(
    const std::string& interface, const std::optional<Link>& link,
    can::FrameProtocol needed = can::FrameProtocol::classic);

/// Records interfaces for a time, or until an interrupt, into a drive that has its configuration
/// and databases; its clock is CLOCK_MONOTONIC. Throws std::invalid_argument or std::system_error
/// for a wrong interface.
void listen(Drive& drive, const std::vector<std::string>& interfaces,
            std::chrono::seconds duration);

/// The frames of one identifier.
struct Identifier {
  std::string bus;
  std::uint32_t id = 0;
  can::IdFormat format = can::IdFormat::standard;
  std::uint64_t frames = 0;
  double rate_hz = 0.0;  ///< 0: a single frame
  std::string message;   ///< name of the mapped message; empty: not mapped
};

/// All received identifiers, ordered by bus and identifier, for a table with the unmapped ones.
[[nodiscard]] std::vector<Identifier> identifiers_of(const Drive& drive);

/// Reports a listen-only interface that receives nothing, or only one frame repeatedly: if
/// no node acknowledges a frame, its sender repeats it without a pause, and stays on the bus.
[[nodiscard]] diagnostics::Diagnostics examine_acknowledgement(const std::string& interface,
                                                               const Link& link,
                                                               const Drive& heard);

/// Reports that no frame came, or mapped messages that are missing, have the other format of
/// identifier or another rate, are too short, or fail their protection.
[[nodiscard]] diagnostics::Diagnostics examine_traffic(const Drive& drive);

// Drives: a replay with the configuration shows whether sensors, camera and reference have the
// right signs, sides, axles, axes, units and times.

struct DriveExamination {
  diagnostics::Diagnostics diagnostics;  ///< causes without their consequences
  std::string note;  ///< checks that were not possible, and guesses of odom init
};

/// How many lines of a configuration odom init has marked as guesses, in words; empty for none.
[[nodiscard]] std::string guesses_in(const std::filesystem::path& config);

/// Finds faults of a drive: in its configuration, in its traffic (examine_traffic()) and
/// in its replay. Throws std::invalid_argument if the drive cannot be replayed.
[[nodiscard]] DriveExamination examine_drive(const Drive& drive);

// The parts of examine_drive() that check sensors beyond the replay.

/// Finds the sensor with a wrong scale. Compares distances of the wheels, turns from gyro, wheels
/// and steering, and accelerations with the poses of camera or reference, and with each other. The
/// result is the factor on one sensor, the wheels of an axle or all wheels that explains the
/// comparisons best (scales.cpp). Nothing if no factor is certain and distinct.
[[nodiscard]] std::optional<diagnostics::Diagnostic> find_wrong_scale(const Drive& drive,
                                                                      const SignalLog& log);

// Finds sensors whose stated latency is wrong, and camera poses that are not on the bus's clock
// (latencies.cpp).

/// Reports each source whose time offset to the gyro is too large, or only the gyro if its wrong
/// latency explains equal offsets of all others.
[[nodiscard]] diagnostics::Diagnostics examine_latencies(const daemon::Config& config,
                                                         std::span<const SourceOffset> offsets);

/// Sources whose latency this drive cannot determine, in words; empty if there are none.
[[nodiscard]] std::string latencies_unjudged(std::span<const SourceOffset> offsets);

}  // namespace odomd::tools::doctor
