/* How a slot is written and read: a sequence lock on relaxed 64-bit words. C11 and C++.
 *
 * There is one writer. Readers never write, so the writer never waits for them. Every access to
 * shared words is atomic, so words are never torn, and races are defined behaviour. A reader must
 * never accept a mixture of words of two ticks as one pose. Three orderings prevent it; x86 needs
 * no instruction for any of them, ARM does for each.
 *
 * Writer, tick k:                          Reader:
 *   W1  sequence = 2k + 1   relaxed          R1  h = head           acquire
 *   W2  fence               release          R2  words              relaxed
 *   W3  words               relaxed          R3  fence              acquire
 *   W4  sequence = 2k + 2   release          R4  sequence == h ?    relaxed
 *   W5  head = 2k + 2       release
 *
 * (a) R2 reads tick k or newer: W5 releases W1 to W4, R1 acquires them. Likewise, it reads other
 *     slots as their last tick before k or newer.
 * (b) R4 detects newer words: if R2 reads one of tick k' > k (W3'), fence W2' synchronizes with
 *     fence R3 through that word, so R4 sees W1' (odd) or a later value, never h. Without W2' the
 *     store W1' might become visible after the words; without R3 the load R4 might be done before
 *     them.
 * (c) W4 is a release store, so that a reader that starts from the sequence of a slot instead of
 *     the head (acquiring it) also gets the words. Readers in this library start from the head.
 *
 * The slot of the head is overwritten only after all other slots: a reader has (slots - 1)
 * periods, which is seconds, for its read.
 */
#ifndef ODOMD_SHM_API_SLOT_H
#define ODOMD_SHM_API_SLOT_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include "shm_api/layout/segment.h"

static inline uint64_t odomi_load(const uint64_t* word) {
  return __atomic_load_n(word, __ATOMIC_RELAXED);
}

/* The linter does not see the stores. NOLINTBEGIN(readability-non-const-parameter) */
static inline void odomi_store(uint64_t* word, uint64_t value) {
  __atomic_store_n(word, value, __ATOMIC_RELAXED);
}

#ifdef __cplusplus
static inline const char* odomi_bytes(const void* from) {
  return static_cast<const char*>(from);
}
static inline char* odomi_writable_bytes(void* to) {
  return static_cast<char*>(to);
}
#else
static inline const char* odomi_bytes(const void* from) {
  return from;
}
static inline char* odomi_writable_bytes(void* to) {
  return to;
}
#endif

/* Converts structs to words and back, in whole words. */
static inline void odomi_copy_in(uint64_t* words, const void* from, size_t count) {
  const char* bytes = odomi_bytes(from);
#pragma GCC unroll 4
  for (size_t i = 0; i < count; ++i) {
    uint64_t word = 0;
    __builtin_memcpy(&word, bytes + 8 * i, sizeof word);
    odomi_store(words + i, word);
  }
}

static inline void odomi_copy_out(void* to, const uint64_t* words, size_t count) {
  char* bytes = odomi_writable_bytes(to);
#pragma GCC unroll 2
  for (size_t i = 0; i < count; ++i) {
    const uint64_t word = odomi_load(words + i);
    __builtin_memcpy(bytes + 8 * i, &word, sizeof word);
  }
}

/* The sequence and the head of a published tick. */
static inline uint64_t odomi_sequence(uint64_t tick) {
  return 2 * tick + 2;
}
static inline uint64_t odomi_tick(uint64_t sequence) {
  return sequence / 2 - 1;
}

/* The checksum of `count` words. Each step is a bijection of the sum and of the word, so that any
 * change of a single word is detected; four independent sums run in parallel. */
static inline uint64_t odomi_checksum(const uint64_t* words, size_t count) {
  uint64_t sums[4] = {1, 2, 3, 4};
  for (size_t i = 0; i < count; ++i) {
    const uint64_t mixed = (sums[i % 4] ^ odomi_load(words + i)) * UINT64_C(0x9E3779B97F4A7C15);
    sums[i % 4] = mixed << 29 | mixed >> 35;
  }
  uint64_t sum = 0;
  for (size_t i = 0; i < 4; ++i) sum = (sum << 7 | sum >> 57) ^ sums[i];
  return sum * UINT64_C(0x9E3779B97F4A7C15);
}

static inline void odomi_write_slot(uint64_t* slot, uint64_t tick, const odom_pose* pose,
                                    const odom_details* details) {
  odomi_store(slot + ODOM_SLOT_SEQUENCE, odomi_sequence(tick) - 1); /* W1 */
  __atomic_thread_fence(__ATOMIC_RELEASE);                          /* W2 */
  odomi_copy_in(slot + ODOM_SLOT_POSE, pose, ODOM_POSE_WORDS);      /* W3 */
  odomi_copy_in(slot + ODOM_SLOT_DETAILS, details, ODOM_DETAILS_WORDS);
  odomi_store(slot + ODOM_SLOT_CHECKSUM,
              odomi_checksum(slot + ODOM_SLOT_POSE, ODOM_POSE_WORDS + ODOM_DETAILS_WORDS));
  __atomic_store_n(slot + ODOM_SLOT_SEQUENCE, odomi_sequence(tick), __ATOMIC_RELEASE); /* W4 */
}

static inline void odomi_write_head(uint64_t* words, uint64_t tick) {
  __atomic_store_n(words + ODOM_HEADER_HEAD, odomi_sequence(tick), __ATOMIC_RELEASE); /* W5 */
}

/* NOLINTEND(readability-non-const-parameter) */

static inline uint64_t odomi_read_head(const uint64_t* words) {
  return __atomic_load_n(words + ODOM_HEADER_HEAD, __ATOMIC_ACQUIRE); /* R1 */
}

/* Whether everything read from a slot since R1 belongs to the tick of `sequence`. */
static inline int odomi_still(const uint64_t* slot, uint64_t sequence) {
  __atomic_thread_fence(__ATOMIC_ACQUIRE);                          /* R3 */
  return odomi_load(slot + ODOM_SLOT_SEQUENCE) == sequence ? 1 : 0; /* R4 */
}

/* NOLINTEND(modernize-*) */

#endif
