/* What an odom_client is, and what the files of libodom share about it. */
#ifndef ODOMD_LIBODOM_CLIENT_H
#define ODOMD_LIBODOM_CLIENT_H

#include <string.h>
#include <time.h>

#include "shm_api/libodom/attach.h"

enum { ODOMI_ATTEMPTS = 3 }; /* of a read that the writer overtakes */

struct odom_client {
  odomi_segment segment;
  int64_t stale_after_ns;   /* age of the heartbeat from which the writer counts as dead */
  int64_t clearly_fresh_ns; /* up to this age the coarse clock suffices to say that it lives */
  int64_t next_attempt_ns;  /* not to look for a successor before */
  odomi_owners owners;
  char* paths[2]; /* where segments of this client may lie; the second may be NULL */
};

static inline int64_t odomi_now(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* ODOM_OK when the writer has ticked lately. Else looks for a successor, at most once in four
 * periods, and goes over to it; ODOM_STALE when there is none. */
odom_status odomi_freshen(odom_client* client);

static inline const uint64_t* odomi_slot(const odomi_segment* segment, uint64_t tick) {
  return segment->slots + (tick & segment->slot_mask) * segment->slot_words;
}

/* Callers pass their structs with the size that they were compiled with: whole words. */
static inline int odomi_is_size(size_t size) {
  return size >= 8 && size % 8 == 0;
}

/* Fills `size` bytes of a caller's struct from a whole one of ours, with zeros beyond it. */
static inline void odomi_give(void* to, size_t size, const void* from, size_t known) {
  memcpy(to, from, size < known ? size : known);
  if (size > known) memset((char*)to + known, 0, size - known);
}

#endif
