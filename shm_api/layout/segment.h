/* The layout of the segment, in 64-bit words, for its writer and for libodom. C11 and C++.
 *
 *   word    0  magic and sizes, fixed before the segment gets its name
 *   word    8  odom_info, word by word as in the struct
 *   word   64  head: 2 * tick + 2 of the newest published slot, 0 before the first
 *   word   65  futex word (the low 32 bits), counts the wake-ups of clients
 *   word   67  odom_beat, word by word as in the struct; word 71 is the heartbeat
 *   word  512  the ring of slots: tick k lies in slot k modulo the number of slots
 *
 * A slot consists of its sequence (2 * tick + 1 while it is written, 2 * tick + 2 after),
 * odom_pose, odom_details, padding to a cache line, and a checksum in its last word. The words of
 * the header that a read needs (head, heartbeat) are in one cache line.
 *
 * The layout is append-only: ABI minor rises when a block grows at its end, ABI major when anything
 * moves. Readers use the sizes in words 1 to 7, so reader and writer may be of different age.
 */
#ifndef ODOMD_SHM_API_SEGMENT_H
#define ODOMD_SHM_API_SEGMENT_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#include <odom/odom.h>

#define ODOM_SEGMENT_MAGIC UINT64_C(0x314745534D4F444F) /* the bytes "ODOMSEG1" */

#define ODOM_WORD_BYTES sizeof(uint64_t)

enum { ODOM_ABI_MAJOR = 1, ODOM_ABI_MINOR = 1 };

enum {
  ODOM_SEGMENT_LINE_WORDS = 8, /* a cache line */

  ODOM_HEADER_MAGIC = 0,
  ODOM_HEADER_BYTES = 1,         /* of the header: where slot 0 begins */
  ODOM_HEADER_SLOT_BYTES = 2,    /* from one slot to the next */
  ODOM_HEADER_SEGMENT_BYTES = 3, /* of the whole segment */
  ODOM_HEADER_POSE_WORDS = 4,
  ODOM_HEADER_DETAILS_WORDS = 5,
  ODOM_HEADER_INFO_WORDS = 6,
  ODOM_HEADER_BEAT_WORDS = 7,

  ODOM_HEADER_INFO = 8, /* up to word 63 */
  ODOM_HEADER_ABI = ODOM_HEADER_INFO + 0,
  ODOM_HEADER_INSTANCE = ODOM_HEADER_INFO + 1,
  ODOM_HEADER_PID = ODOM_HEADER_INFO + 2,
  ODOM_HEADER_PERIOD = ODOM_HEADER_INFO + 4,
  ODOM_HEADER_FIRST_TICK = ODOM_HEADER_INFO + 5,
  ODOM_HEADER_REALTIME_OFFSET = ODOM_HEADER_INFO + 6,
  ODOM_HEADER_LOG_OFFSET = ODOM_HEADER_INFO + 7,
  ODOM_HEADER_SLOTS = ODOM_HEADER_INFO + 8,

  ODOM_HEADER_HEAD = 64,
  ODOM_HEADER_FUTEX = 65,

  ODOM_HEADER_BEAT = 67, /* up to word 511 */
  ODOM_HEADER_TICKS = ODOM_HEADER_BEAT + 0,
  ODOM_HEADER_MISSED = ODOM_HEADER_BEAT + 1,
  ODOM_HEADER_OVERRUNS = ODOM_HEADER_BEAT + 2,
  ODOM_HEADER_CARRIED_OVER = ODOM_HEADER_BEAT + 3,
  ODOM_HEADER_HEARTBEAT = ODOM_HEADER_BEAT + 4,
  ODOM_HEADER_LAST_OVERRUN = ODOM_HEADER_BEAT + 5,
  ODOM_HEADER_LAST_OVERRUN_EXECUTION = ODOM_HEADER_BEAT + 6,
  ODOM_HEADER_MAX_WAKEUP = ODOM_HEADER_BEAT + 7,
  ODOM_HEADER_MAX_EXECUTION = ODOM_HEADER_BEAT + 8,
  ODOM_HEADER_WAKEUP = ODOM_HEADER_BEAT + 9,
  ODOM_HEADER_EXECUTION = ODOM_HEADER_WAKEUP + ODOM_HISTOGRAM_BUCKETS,

  ODOM_SEGMENT_HEADER_WORDS = 512,

  ODOM_POSE_WORDS = 28,
  ODOM_DETAILS_WORDS = 69,
  ODOM_INFO_WORDS = 24,
  ODOM_BEAT_WORDS = 137,

  ODOM_SLOT_SEQUENCE = 0,
  ODOM_SLOT_POSE = 1,
  ODOM_SLOT_DETAILS = ODOM_SLOT_POSE + ODOM_POSE_WORDS,
  ODOM_SLOT_WORDS = 104,    /* 98 are used; odom_details may grow */
  ODOM_SLOT_CHECKSUM = 103, /* last word, of pose and details, for the writer's successor only */

  ODOM_SEGMENT_SLOTS_MIN = 4,
  ODOM_SEGMENT_SLOTS_MAX = 1 << 20,

  ODOM_STALE_PERIODS = 4 /* without a heartbeat, until clients consider the writer dead */
};

/* 100 us to 1 s: the range of the beat; four periods cannot overflow. */
#define ODOM_PERIOD_MIN_NS INT64_C(100000)
#define ODOM_PERIOD_MAX_NS INT64_C(1000000000)

/* The largest tick whose sequence fits into a word. */
#define ODOM_TICK_MAX (UINT64_MAX / 2 - 1)

/* The structs match the words. */
static_assert(sizeof(odom_pose) == ODOM_WORD_BYTES * ODOM_POSE_WORDS, "odom_pose is fixed");
static_assert(sizeof(odom_details) == ODOM_WORD_BYTES * ODOM_DETAILS_WORDS, "raise ABI minor");
static_assert(sizeof(odom_info) == ODOM_WORD_BYTES * ODOM_INFO_WORDS, "raise ABI minor");
static_assert(sizeof(odom_beat) == ODOM_WORD_BYTES * ODOM_BEAT_WORDS, "raise ABI minor");

#define ODOM_LIES_AT(type, field, word)                            \
  static_assert(offsetof(type, field) == ODOM_WORD_BYTES * (word), \
                #type "." #field " has moved: raise ABI major")
ODOM_LIES_AT(odom_pose, tick, ODOM_WORD_TICK - 1);
ODOM_LIES_AT(odom_pose, time_ns, ODOM_WORD_TIME - 1);
ODOM_LIES_AT(odom_pose, covariance, ODOM_WORD_COVARIANCE - 1);
ODOM_LIES_AT(odom_pose, mode, ODOM_WORD_MODE - 1);
ODOM_LIES_AT(odom_pose, reset_count, ODOM_WORD_RESETS - 1);
ODOM_LIES_AT(odom_pose, jump_yaw, ODOM_WORD_JUMP_YAW - 1);
ODOM_LIES_AT(odom_info, instance_id, ODOM_HEADER_INSTANCE - ODOM_HEADER_INFO);
ODOM_LIES_AT(odom_info, period_ns, ODOM_HEADER_PERIOD - ODOM_HEADER_INFO);
ODOM_LIES_AT(odom_info, slots, ODOM_HEADER_SLOTS - ODOM_HEADER_INFO);
ODOM_LIES_AT(odom_beat, heartbeat_ns, ODOM_HEADER_HEARTBEAT - ODOM_HEADER_BEAT);
ODOM_LIES_AT(odom_beat, max_execution_ns, ODOM_HEADER_MAX_EXECUTION - ODOM_HEADER_BEAT);
ODOM_LIES_AT(odom_beat, execution, ODOM_HEADER_EXECUTION - ODOM_HEADER_BEAT);
#undef ODOM_LIES_AT

/* The blocks do not overlap, and are aligned to cache lines where it matters. */
static_assert(ODOM_SLOT_DETAILS == ODOM_WORD_DETAILS - ODOM_WORD_TICK + ODOM_SLOT_POSE,
              "details follow the pose");
static_assert(ODOM_HEADER_INFO + ODOM_INFO_WORDS <= ODOM_HEADER_HEAD, "info fits");
static_assert(ODOM_HEADER_BEAT + ODOM_BEAT_WORDS <= ODOM_SEGMENT_HEADER_WORDS, "beat fits");
static_assert(ODOM_SLOT_DETAILS + ODOM_DETAILS_WORDS <= ODOM_SLOT_CHECKSUM, "a slot fits");
static_assert(ODOM_SLOT_CHECKSUM == ODOM_SLOT_WORDS - 1, "found without knowing the details' size");
static_assert(ODOM_HEADER_HEAD % ODOM_SEGMENT_LINE_WORDS == 0, "head begins a line");
static_assert(ODOM_HEADER_HEARTBEAT < ODOM_HEADER_HEAD + ODOM_SEGMENT_LINE_WORDS,
              "head and heartbeat share a line");
static_assert(ODOM_SEGMENT_HEADER_WORDS % ODOM_SEGMENT_LINE_WORDS == 0, "slots begin a line");
static_assert(ODOM_SLOT_WORDS % ODOM_SEGMENT_LINE_WORDS == 0, "slots begin a line");

static_assert(sizeof(size_t) == sizeof(uint64_t) && __GCC_ATOMIC_LLONG_LOCK_FREE == 2,
              "the segment needs 64-bit atomics without locks");
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "halves of words: low half first");

/* NOLINTEND(modernize-*) */

#endif
