#include "shm_api/writer.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif
#include <linux/futex.h>
#include <sys/random.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <ctime>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/attach.h"
#include "shm_api/segment_file.hpp"

namespace odomd::shm {
namespace {

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::uint64_t make_instance_id() {
  std::uint64_t id = 0;
  if (getrandom(&id, sizeof id, 0) != sizeof id)
    throw std::system_error(errno, std::generic_category(), "getrandom");
  return id;
}

void check(const SegmentSettings& settings) {
  if (settings.slots < ODOM_SEGMENT_SLOTS_MIN || settings.slots > ODOM_SEGMENT_SLOTS_MAX ||
      (settings.slots & (settings.slots - 1)) != 0)
    throw std::invalid_argument("[shm] slots: " + std::to_string(settings.slots) +
                                ": set a power of two from 4 to 1048576");
  // Clients refuse a segment that anyone but its owner may write.
  if ((settings.mode & ~0644U) != 0 || (settings.mode & 0600U) != 0600U)
    throw std::invalid_argument("[shm] mode: set 0600, 0640 or 0644");
}

void check(const odom_info& info) {
  if (info.period_ns < ODOM_PERIOD_MIN_NS || info.period_ns > ODOM_PERIOD_MAX_NS)
    throw std::invalid_argument("[realtime] period: set 0.0001 to 1 s");
}

struct Predecessor {
  std::optional<Inheritance> last;
  bool damaged = false;
};

// Uses the head: the tick in a damaged pose may name another slot.
bool is_newest_whole(const odomi_segment& segment) {
  const std::uint64_t tick = odomi_tick(odomi_read_head(segment.words));
  const std::uint64_t* slot = segment.slots + (tick & segment.slot_mask) * segment.slot_words;
  return odomi_load(slot + segment.slot_words - 1) ==
         odomi_checksum(slot + ODOM_SLOT_POSE, ODOM_POSE_WORDS + segment.details_words);
}

// The last pose of the previous writer under this name, if it is trusted.
Predecessor read_predecessor(const std::string& path) {
  const odomi_owners owners{{0, geteuid()}, 2};
  odomi_segment segment{};
  const odom_status attached = odomi_attach(path.c_str(), &owners, nullptr, &segment);
  if (attached != ODOM_OK) return {std::nullopt, attached == ODOM_ABI};
  Predecessor found;
  found.last.emplace();
  odomi_read_info(&segment, &found.last->info);
  const odom_status read = odomi_newest(&segment, &found.last->pose, &found.last->details);
  found.damaged = read == ODOM_BUSY || (read == ODOM_OK && !is_newest_whole(segment));
  if (read != ODOM_OK || found.damaged) found.last.reset();
  odomi_detach(&segment);
  return found;
}

// Bucket 0 is [0, 1) us, bucket i >= 1 is [2^((i-1)/4), 2^(i/4)) us: four per octave. Here: the
// lower bounds of buckets 1 and up, in ns, rounded up since counted times are whole.
constexpr auto bucket_bounds = [] {
  constexpr std::array<double, 4> quarter{1000.0, 1189.2071150027210, 1414.2135623730951,
                                          1681.7928305074290};
  std::array<std::int64_t, ODOM_HISTOGRAM_BUCKETS - 1> bounds{};
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const double exact = quarter.at(i % 4) * static_cast<double>(std::int64_t{1} << (i / 4));
    const auto floor = static_cast<std::int64_t>(exact);
    bounds.at(i) = floor + (static_cast<double>(floor) < exact ? 1 : 0);
  }
  return bounds;
}();

std::size_t bucket_of(std::int64_t ns) noexcept {
  const auto* bound = std::upper_bound(bucket_bounds.begin(), bucket_bounds.end(), ns);
  return static_cast<std::size_t>(bound - bucket_bounds.begin());
}

// Only the beat increments, so a load and a store are sufficient.
void add(std::uint64_t* word, std::uint64_t amount) noexcept {
  odomi_store(word, odomi_load(word) + amount);
}

void store_time(std::uint64_t* word, std::int64_t ns) noexcept {
  odomi_store(word, static_cast<std::uint64_t>(ns));
}

void count_time(std::uint64_t* histogram, std::uint64_t* maximum, std::int64_t ns) noexcept {
  add(histogram + bucket_of(ns), 1);
  if (ns > static_cast<std::int64_t>(odomi_load(maximum))) store_time(maximum, ns);
}

// Moves the cache lines that this core has written to the shared cache, from which a reader gets
// them in a third of the time. CLDEMOTE is only a hint; older processors ignore it.
#if defined(__x86_64__)
__attribute__((target("cldemote"))) void hand_over(std::uint64_t* words,
                                                   std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; i += ODOM_SEGMENT_LINE_WORDS) _cldemote(words + i);
}
#else
void hand_over(std::uint64_t* /*words*/, std::size_t /*count*/) noexcept {}
#endif

}  // namespace

struct Claim::State {
  SegmentSettings settings;
  std::string path;
  SegmentLock lock;
  Predecessor predecessor;

  explicit State(const SegmentSettings& wanted)
      : settings(wanted),
        path(segment_path(wanted.name)),
        lock(lock_segment(path)),
        predecessor(read_predecessor(path)) {}
};

Claim::Claim(const SegmentSettings& settings) {
  check(settings);
  state_ = std::make_unique<State>(settings);
}

Claim::~Claim() = default;
Claim::Claim(Claim&& other) noexcept = default;

const std::optional<Inheritance>& Claim::predecessor() const noexcept {
  return state_->predecessor.last;
}

bool Claim::predecessor_is_damaged() const noexcept {
  return state_->predecessor.damaged;
}

namespace {

/// One segment file, from its creation on.
struct Segment {
  UnnamedSegment file;
  odom_info info;
  FileId id;
  std::uint64_t* words;
  std::uint64_t* slots;

  Segment(const std::string& path, std::uint64_t slot_count, const odom_info& given)
      : file(create_segment(path, sizeof(std::uint64_t) *
                                      (ODOM_SEGMENT_HEADER_WORDS + slot_count * ODOM_SLOT_WORDS))),
        info(given),
        id(id_of(file.file.get())),
        words(file.words.get()),
        slots(words + ODOM_SEGMENT_HEADER_WORDS) {
    info.slots = slot_count;
    info.instance_id = make_instance_id();
    write_header();
  }

  [[nodiscard]] std::uint64_t* word(std::size_t index) const noexcept { return words + index; }
  void hand_over_head() const noexcept {
    hand_over(word(ODOM_HEADER_HEAD), ODOM_SEGMENT_LINE_WORDS);
  }

  /// Copies the beat's counts and settings from the segment that this one replaces.
  void continue_from(const Segment& before) const noexcept {
    const auto copy = [&](std::size_t index) {
      odomi_store(word(index), odomi_load(before.word(index)));
    };
    copy(ODOM_HEADER_FIRST_TICK);
    copy(ODOM_HEADER_REALTIME_OFFSET);
    copy(ODOM_HEADER_LOG_OFFSET);
    for (std::size_t i = 0; i < ODOM_BEAT_WORDS; ++i) copy(ODOM_HEADER_BEAT + i);
  }

 private:
  void write_header() const {
    odomi_store(word(ODOM_HEADER_MAGIC), ODOM_SEGMENT_MAGIC);
    odomi_store(word(ODOM_HEADER_BYTES), ODOM_WORD_BYTES * ODOM_SEGMENT_HEADER_WORDS);
    odomi_store(word(ODOM_HEADER_SLOT_BYTES), ODOM_WORD_BYTES * ODOM_SLOT_WORDS);
    odomi_store(word(ODOM_HEADER_SEGMENT_BYTES), file.words.get_deleter().bytes);
    odomi_store(word(ODOM_HEADER_POSE_WORDS), ODOM_POSE_WORDS);
    odomi_store(word(ODOM_HEADER_DETAILS_WORDS), ODOM_DETAILS_WORDS);
    odomi_store(word(ODOM_HEADER_INFO_WORDS), ODOM_INFO_WORDS);
    odomi_store(word(ODOM_HEADER_BEAT_WORDS), ODOM_BEAT_WORDS);
    odomi_copy_in(word(ODOM_HEADER_INFO), &info, ODOM_INFO_WORDS);
    store_time(word(ODOM_HEADER_HEARTBEAT), monotonic_ns());
  }
};

odom_info completed(odom_info info) {
  info.abi_major = ODOM_ABI_MAJOR;
  info.abi_minor = ODOM_ABI_MINOR;
  info.writer_pid = getpid();
  info.writer_start_ns = monotonic_ns();
  return info;
}

}  // namespace

// The beat writes to `live`. When housekeeping has created another segment, it is `next` until the
// beat switches to it with its next tick.
struct Writer::State {
  Claim claim;
  std::vector<std::unique_ptr<Segment>> segments;  // housekeeping's: the live one, and the next
  std::atomic<Segment*> live;
  std::atomic<Segment*> next{nullptr};
  std::mutex waking;  // held by the relay while it uses the live segment

  State(Claim&& claimed, std::unique_ptr<Segment> first)
      : claim(std::move(claimed)), live(first.get()) {
    segments.push_back(std::move(first));
  }

  /// For the beat and housekeeping.
  [[nodiscard]] const Segment& segment() const noexcept {
    return *live.load(std::memory_order_acquire);
  }
  [[nodiscard]] std::uint64_t* word(std::size_t index) const noexcept {
    return segment().word(index);
  }

  void switch_to_next() noexcept {
    Segment* const made = next.load(std::memory_order_acquire);
    if (made == nullptr) return;
    made->continue_from(segment());
    live.store(made, std::memory_order_release);
    next.store(nullptr, std::memory_order_release);
  }

  /// Drops the segments that the beat no longer uses.
  void drop_old() {
    if (segments.size() == 1 || next.load(std::memory_order_acquire) != nullptr) return;
    const std::lock_guard hold(waking);
    const Segment* const kept = live.load(std::memory_order_acquire);
    std::erase_if(segments, [&](const auto& one) { return one.get() != kept; });
  }
};

Writer::Writer(Claim claim, const odom_info& info) {
  check(info);
  const Claim::State& name = *claim.state_;  // its address does not change when the claim moves
  auto first = std::make_unique<Segment>(name.path, name.settings.slots, completed(info));
  name_segment(first->file, name.path, name.settings);
  state_ = std::make_unique<State>(std::move(claim), std::move(first));
}

Writer::~Writer() = default;

const std::optional<Inheritance>& Writer::predecessor() const noexcept {
  return state_->claim.predecessor();
}

bool Writer::publish(const odom_pose& pose, const odom_details& details) noexcept {
  state_->switch_to_next();
  const Segment& segment = state_->segment();
  const std::uint64_t head = odomi_load(segment.word(ODOM_HEADER_HEAD));
  if (pose.tick > ODOM_TICK_MAX || odomi_sequence(pose.tick) <= head) return false;
  std::uint64_t* slot = segment.slots + (pose.tick & (segment.info.slots - 1)) * ODOM_SLOT_WORDS;
  odomi_write_slot(slot, pose.tick, &pose, &details);
  odomi_write_head(segment.words, pose.tick);
  hand_over(slot, ODOM_SLOT_WORDS);
  add(state_->word(ODOM_HEADER_TICKS), 1);
  return true;
}

void Writer::set_first_tick(std::int64_t first_tick_ns) noexcept {
  store_time(state_->word(ODOM_HEADER_FIRST_TICK), first_tick_ns);
}

void Writer::set_heartbeat(std::int64_t now_ns) noexcept {
  store_time(state_->word(ODOM_HEADER_HEARTBEAT), now_ns);
  state_->segment().hand_over_head();
}

void Writer::count_wakeup(std::int64_t latency_ns) noexcept {
  count_time(state_->word(ODOM_HEADER_WAKEUP), state_->word(ODOM_HEADER_MAX_WAKEUP), latency_ns);
}

void Writer::count_execution(std::int64_t execution_ns) noexcept {
  count_time(state_->word(ODOM_HEADER_EXECUTION), state_->word(ODOM_HEADER_MAX_EXECUTION),
             execution_ns);
}

void Writer::count_missed(std::uint64_t cycles) noexcept {
  add(state_->word(ODOM_HEADER_MISSED), cycles);
}

void Writer::count_overrun(std::int64_t now_ns, std::int64_t execution_ns) noexcept {
  add(state_->word(ODOM_HEADER_OVERRUNS), 1);
  store_time(state_->word(ODOM_HEADER_LAST_OVERRUN), now_ns);
  store_time(state_->word(ODOM_HEADER_LAST_OVERRUN_EXECUTION), execution_ns);
}

void Writer::count_carried_over() noexcept {
  add(state_->word(ODOM_HEADER_CARRIED_OVER), 1);
}

void Writer::set_realtime_offset(std::int64_t offset_ns) noexcept {
  store_time(state_->word(ODOM_HEADER_REALTIME_OFFSET), offset_ns);
}

void Writer::set_log_offset(std::int64_t offset_ns) noexcept {
  store_time(state_->word(ODOM_HEADER_LOG_OFFSET), offset_ns);
}

Upkeep Writer::maintain() {
  state_->drop_old();
  Claim::State& name = *state_->claim.state_;
  const bool locked = id_of(name.path + ".lock") == id_of(name.lock.file.get());
  if (!locked) renew_lock_file(name.lock, name.path);
  const bool unchanged = id_of(name.path) == state_->segments.back()->id;
  if (unchanged) return locked ? Upkeep::unchanged : Upkeep::lock_renewed;
  if (state_->segments.size() > 1) return Upkeep::recreated;  // the beat has not switched yet
  if (id_of(name.path) != FileId{}) refuse_foreign(name.path);
  auto made = std::make_unique<Segment>(name.path, name.settings.slots, state_->segment().info);
  name_segment(made->file, name.path, name.settings);
  state_->segments.push_back(std::move(made));
  state_->next.store(state_->segments.back().get(), std::memory_order_release);
  return Upkeep::recreated;
}

void Writer::wake_clients() noexcept {
  const std::lock_guard hold(state_->waking);
  const Segment& segment = state_->segment();
  // Release: a client that acquires the new count sees what was published before the wake-up. The
  // kernel compares the low half of the word, which wraps by itself.
  std::uint64_t* futex = segment.word(ODOM_HEADER_FUTEX);
  __atomic_fetch_add(futex, 1, __ATOMIC_RELEASE);
  segment.hand_over_head();
  syscall(SYS_futex, futex, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

odom_beat Writer::beat() const noexcept {
  odom_beat beat;
  odomi_copy_out(&beat, state_->word(ODOM_HEADER_BEAT), ODOM_BEAT_WORDS);
  return beat;
}

odom_info Writer::info() const noexcept {
  return state_->segment().info;
}

}  // namespace odomd::shm
