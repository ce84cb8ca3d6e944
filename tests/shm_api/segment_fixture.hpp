// Shared by the tests of the segment: a directory, and poses in which every word depends on the
// tick.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <utility>

#include <odom/odom.h>

#include "shm_api/layout/segment.h"
#include "shm_api/writer.hpp"
#include "tests/scratch.hpp"

namespace odomd::shm::testing {

inline constexpr std::int64_t period_ns = 5'000'000;

/// A directory for one test.
struct TemporaryDirectory : Scratch {
  [[nodiscard]] std::string file(std::string_view name) const { return path(name); }
};

inline std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

inline odom_info test_info(std::int64_t period = period_ns) {
  odom_info info{};
  info.period_ns = period;
  info.mass = 2.985;
  info.track_width = 0.16;
  std::strncpy(info.model, "paper", sizeof info.model - 1);
  std::strncpy(info.version, "0.1.0", sizeof info.version - 1);
  return info;
}

/// Word `index` of a tick, different for every pair of index and tick.
constexpr std::uint64_t pattern(std::uint64_t tick, std::size_t index) {
  std::uint64_t z = tick * 0x9E3779B97F4A7C15U + (index + 1) * 0xBF58476D1CE4E5B9U;
  z ^= z >> 29U;
  return z * 0x94D049BB133111EBU;
}

struct Record {
  odom_pose pose;
  odom_details details;
};

/// All words except tick and time follow the pattern of the tick.
inline Record patterned(std::uint64_t tick, std::int64_t time_ns) {
  std::array<std::uint64_t, ODOM_POSE_WORDS + ODOM_DETAILS_WORDS> words{};
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = pattern(tick, i);
  words[0] = tick;
  words[1] = static_cast<std::uint64_t>(time_ns);
  Record record;
  static_assert(sizeof record == sizeof words);
  std::memcpy(&record, words.data(), sizeof record);
  return record;
}

/// Whether all words of a pose (and its details) belong to its tick.
inline bool is_whole(const odom_pose& pose, const odom_details* details = nullptr) {
  const Record record{pose, details != nullptr ? *details : odom_details{}};
  const std::size_t count = ODOM_POSE_WORDS + (details != nullptr ? ODOM_DETAILS_WORDS : 0);
  std::array<std::uint64_t, ODOM_POSE_WORDS + ODOM_DETAILS_WORDS> words{};
  std::memcpy(words.data(), &record, sizeof record);
  for (std::size_t i = 2; i < count; ++i)
    if (words[i] != pattern(pose.tick, i)) return false;
  return true;
}

/// Bitwise equality.
template <class Struct>
bool is_same(const Struct& a, const Struct& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

inline void publish_patterned(Writer& writer, std::uint64_t tick, std::int64_t time_ns) {
  const Record record = patterned(tick, time_ns);
  writer.publish(record.pose, record.details);
}

/// A plausible pose: 1 m/s along x, valid at tick * period.
inline odom_pose moving_pose(std::uint64_t tick) {
  const auto time_ns = static_cast<std::int64_t>(tick) * period_ns;
  const double x = static_cast<double>(time_ns) * 1e-9;
  return {.tick = tick, .time_ns = time_ns, .x = x, .odom_x = x, .vx = 1.0, .mode = ODOM_TRACKING};
}

struct CloseClient {
  void operator()(odom_client* client) const noexcept { odom_close(client); }
};
using ClientPointer = std::unique_ptr<odom_client, CloseClient>;

inline ClientPointer open_client(const std::string& path) {
  odom_client* client = nullptr;
  const odom_status status = odom_open(path.c_str(), &client);
  if (status != ODOM_OK) throw std::runtime_error(path + ": " + odom_strstatus(status));
  return ClientPointer(client);
}

/// A client of a writer that published one tick and has ended.
inline ClientPointer client_of_dead_writer(const SegmentSettings& settings, std::uint64_t tick) {
  constexpr std::int64_t fast_ns = 1'000'000;  // stale after 4 ms
  Writer writer(settings, test_info(fast_ns));
  publish_patterned(writer, tick, now_ns());
  ClientPointer client = open_client(settings.name);
  writer.set_heartbeat(now_ns() - 10 * fast_ns);
  return client;
}

using Latest = std::pair<odom_status, std::uint64_t>;

/// The status of odom_latest, and the tick of the pose that it returns.
inline Latest latest(const ClientPointer& client) {
  odom_pose pose{};
  const odom_status status = odom_latest(client.get(), &pose, sizeof pose);
  return {status, pose.tick};
}

inline odom_info info_of(const ClientPointer& client) {
  odom_info info{};
  odom_get_info(client.get(), &info, sizeof info);
  return info;
}

}  // namespace odomd::shm::testing
