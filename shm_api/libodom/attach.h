/* Finds a segment, decides whether it is to be trusted, and maps it read-only. */
#ifndef ODOMD_LIBODOM_ATTACH_H
#define ODOMD_LIBODOM_ATTACH_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <odom/odom.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The owners whose segments are trusted. */
typedef struct odomi_owners {
  uid_t uid[3];
  size_t count;
} odomi_owners;

/* A mapped segment with a consistent header. */
typedef struct odomi_segment {
  void* memory; /* the mapping that `words` points to, for munmap() */
  const uint64_t* words;
  size_t bytes;
  const uint64_t* slots;
  uint64_t slot_mask;
  size_t slot_words;
  size_t info_words;
  size_t details_words;
  size_t beat_words;
  int64_t period_ns;
  uint64_t instance_id;
  dev_t device;
  ino_t inode;
  uint64_t expected_head; /* the head after the newest seen, and its slot below */
  const uint64_t* expected_slot;
} odomi_segment;

/* The path of a segment: "/name" is a POSIX shm name (a file in /dev/shm), anything else with a
 * slash in it is a path. ODOM_INVALID for a name that is neither. The path is malloc'ed. */
odom_status odomi_path(const char* name, char** path);

/* Opens, checks and maps. If it is the file of `known` (may be NULL), does not map it again:
 * ODOM_OK with segment->words == NULL. */
odom_status odomi_attach(const char* path, const odomi_owners* owners, const odomi_segment* known,
                         odomi_segment* segment);
void odomi_detach(odomi_segment* segment);

/* Copies the newest pose, and its details if requested, from a segment. ODOM_OK; ODOM_NO_POSE: both
 * are unchanged; ODOM_BUSY: both are zero, with mode ODOM_FAULT. */
odom_status odomi_newest(odomi_segment* segment, odom_pose* pose, odom_details* details);

void odomi_read_info(const odomi_segment* segment, odom_info* info);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif
