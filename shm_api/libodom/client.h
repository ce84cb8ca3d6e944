/* Defines odom_client, and the functions for it that the files of libodom share. */
#ifndef ODOMD_LIBODOM_CLIENT_H
#define ODOMD_LIBODOM_CLIENT_H

#include <string.h>
#include <time.h>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/attach.h"

enum { ODOMI_ATTEMPTS = 3 }; /* of a read that the writer overtakes */

struct odom_client {
  odomi_segment segment;
  int64_t stale_after_ns;   /* age of the heartbeat from which the writer counts as dead */
  int64_t clearly_fresh_ns; /* up to this age on the coarse clock, the writer lives */
  int64_t next_attempt_ns;  /* no search for a successor before this time */
  odomi_owners owners;
  char* paths[2]; /* where segments of this client may lie; the second may be NULL */
};

static inline int64_t odomi_now(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static inline int odomi_is_fresh(const odomi_segment* segment, int64_t now_ns, int64_t limit_ns) {
  /* A heartbeat far in the future comes from another clock (a time namespace) and is not usable. */
  const int64_t heartbeat_ns = (int64_t)odomi_load(segment->words + ODOM_HEADER_HEARTBEAT);
  int64_t age_ns = 0;
  if (__builtin_sub_overflow(now_ns, heartbeat_ns, &age_ns)) return 0;
  return age_ns <= limit_ns && age_ns >= -(ODOM_STALE_PERIODS * segment->period_ns);
}

/* The part of odomi_freshen() that runs if the coarse clock does not suffice. */
odom_status odomi_look_again(odom_client* client);

/* ODOM_OK when the writer has ticked recently. Otherwise looks for a successor, at most once in
 * four periods, and switches to it; ODOM_STALE when there is none. */
static inline odom_status odomi_freshen(odom_client* client) {
  /* The coarse clock costs a quarter of the fine one and lags behind it by at most a kernel tick: a
   * heartbeat that is fresh by more than that on the coarse clock is fresh. */
  const int64_t now_ns = odomi_now(CLOCK_MONOTONIC_COARSE);
  return odomi_is_fresh(&client->segment, now_ns, client->clearly_fresh_ns)
             ? ODOM_OK
             : odomi_look_again(client);
}

static inline const uint64_t* odomi_slot(const odomi_segment* segment, uint64_t tick) {
  return segment->slots + (tick & segment->slot_mask) * segment->slot_words;
}

/* The slot of a head, usually the one after the previous slot if the caller reads once per tick.
 * This is a branch instead of arithmetic, so that the processor can predict it and fetch the slot
 * while the head is still being loaded from the writer's core: the two cache misses overlap. The
 * words are used only after the head has arrived (R1). */
static inline const uint64_t* odomi_head_slot(odomi_segment* segment, uint64_t head) {
  const uint64_t* slot = segment->expected_slot;
  if (head != segment->expected_head) {
    __asm__(""); /* otherwise the compiler turns the branch into arithmetic */
    slot = odomi_slot(segment, odomi_tick(head));
  }
  segment->expected_head = head + 2;
  segment->expected_slot = odomi_slot(segment, odomi_tick(head + 2));
  return slot;
}

/* Callers pass the size of their structs at compile time: whole words. */
static inline int odomi_is_size(size_t size) {
  return size >= 8 && size % 8 == 0;
}

/* Fills `size` bytes of a caller's struct from one of ours, with zeros after it. */
static inline void odomi_give(void* to, size_t size, const void* from, size_t known) {
  memcpy(to, from, size < known ? size : known);
  if (size > known) memset((char*)to + known, 0, size - known);
}

#endif
