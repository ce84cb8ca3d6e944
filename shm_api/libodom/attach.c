/* Finds a segment, decides whether it is to be trusted, and maps it read-only.
 *
 * Anyone may create names in /dev/shm, so a file is not trusted until its owner is known. All
 * checks are made on the opened file, never on the name, which may change in between. Nobody but
 * its owner can truncate a file that only the owner may write, and the writer never does: with the
 * size checked here, no access can raise SIGBUS.
 */
#include "shm_api/libodom/attach.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "shm_api/layout/slot.h"

static const uint64_t header_minimum = ODOM_WORD_BYTES * ODOM_SEGMENT_HEADER_WORDS;
static const char shm_directory[] = "/dev/shm";

odom_status odomi_path(const char* name, char** path) {
  const size_t length = strlen(name);
  const char* slash = strrchr(name, '/');
  if (slash == NULL || slash[1] == '\0' || length >= PATH_MAX - sizeof shm_directory)
    return ODOM_INVALID;
  if (strcmp(slash, "/.") == 0 || strcmp(slash, "/..") == 0) return ODOM_INVALID;

  const int is_shm_name = slash == name;
  const size_t prefix = is_shm_name ? sizeof shm_directory - 1 : 0;
  char* result = malloc(prefix + length + 1);
  if (result == NULL) return ODOM_SYSTEM;
  memcpy(result, shm_directory, prefix);
  memcpy(result + prefix, name, length + 1);
  *path = result;
  return ODOM_OK;
}

static odom_status status_of_open_error(void) {
  switch (errno) {
    case ENOENT:
    case ENOTDIR:
      return ODOM_NO_SEGMENT;
    case EACCES:
    case EPERM:
    case ELOOP: /* a symbolic link: not made by odomd */
    case ENXIO: /* a socket or a FIFO */
      return ODOM_REFUSED;
    case ENAMETOOLONG:
      return ODOM_INVALID;
    default:
      return ODOM_SYSTEM;
  }
}

static int is_trusted(const struct stat* file, const odomi_owners* owners) {
  if (!S_ISREG(file->st_mode) || (file->st_mode & (S_IWGRP | S_IWOTH)) != 0) return 0;
  for (size_t i = 0; i < owners->count; ++i)
    if (file->st_uid == owners->uid[i]) return 1;
  return 0;
}

/* The header's sizes fit each other and the file. */
static odom_status check_header(odomi_segment* segment) {
  const uint64_t* words = segment->words;
  if (odomi_load(words + ODOM_HEADER_MAGIC) != ODOM_SEGMENT_MAGIC) return ODOM_ABI;
  if ((uint32_t)odomi_load(words + ODOM_HEADER_ABI) != ODOM_ABI_MAJOR) return ODOM_ABI;

  const uint64_t header_bytes = odomi_load(words + ODOM_HEADER_BYTES);
  const uint64_t slot_bytes = odomi_load(words + ODOM_HEADER_SLOT_BYTES);
  const uint64_t segment_bytes = odomi_load(words + ODOM_HEADER_SEGMENT_BYTES);
  const uint64_t details = odomi_load(words + ODOM_HEADER_DETAILS_WORDS);
  const uint64_t info = odomi_load(words + ODOM_HEADER_INFO_WORDS);
  const uint64_t beat = odomi_load(words + ODOM_HEADER_BEAT_WORDS);
  const uint64_t slots = odomi_load(words + ODOM_HEADER_SLOTS);
  const int64_t period_ns = (int64_t)odomi_load(words + ODOM_HEADER_PERIOD);

  const uint64_t big = 1u << 20; /* keeps the products below from overflowing */
  const uint64_t line_bytes = ODOM_WORD_BYTES * ODOM_SEGMENT_LINE_WORDS;
  if (header_bytes < header_minimum || header_bytes > big || header_bytes % line_bytes != 0)
    return ODOM_ABI;
  if (odomi_load(words + ODOM_HEADER_POSE_WORDS) != ODOM_POSE_WORDS) return ODOM_ABI;
  if (slot_bytes > big || slot_bytes % line_bytes != 0 || details > big ||
      ODOM_WORD_BYTES * (ODOM_SLOT_DETAILS + details) > slot_bytes)
    return ODOM_ABI;
  if (slots < ODOM_SEGMENT_SLOTS_MIN || slots > ODOM_SEGMENT_SLOTS_MAX ||
      (slots & (slots - 1)) != 0)
    return ODOM_ABI;
  if (info < ODOM_INFO_WORDS || ODOM_HEADER_INFO + info > ODOM_HEADER_HEAD) return ODOM_ABI;
  if (beat < ODOM_BEAT_WORDS || ODOM_HEADER_BEAT + beat > ODOM_SEGMENT_HEADER_WORDS)
    return ODOM_ABI;
  if (segment_bytes != header_bytes + slots * slot_bytes || segment_bytes > segment->bytes)
    return ODOM_ABI;
  if (period_ns < ODOM_PERIOD_MIN_NS || period_ns > ODOM_PERIOD_MAX_NS) return ODOM_ABI;

  segment->slots = words + header_bytes / ODOM_WORD_BYTES;
  segment->slot_mask = slots - 1;
  segment->slot_words = slot_bytes / ODOM_WORD_BYTES;
  segment->details_words = details;
  segment->info_words = info;
  segment->beat_words = beat;
  segment->period_ns = period_ns;
  segment->instance_id = odomi_load(words + ODOM_HEADER_INSTANCE);
  return ODOM_OK;
}

static odom_status map_file(int file, const odomi_owners* owners, const odomi_segment* known,
                            odomi_segment* segment) {
  struct stat status;
  if (fstat(file, &status) != 0) return ODOM_SYSTEM;
  if (!is_trusted(&status, owners)) return ODOM_REFUSED;
  if (known != NULL && known->device == status.st_dev && known->inode == status.st_ino)
    return ODOM_OK;
  if (status.st_size < (off_t)header_minimum) return ODOM_ABI;

  /* Populated, so that a control loop has no page fault on the first access to each slot. */
  const size_t bytes = (size_t)status.st_size;
  void* memory = mmap(NULL, bytes, PROT_READ, MAP_SHARED | MAP_POPULATE, file, 0);
  if (memory == MAP_FAILED) return ODOM_SYSTEM;

  segment->memory = memory;
  segment->words = memory;
  segment->bytes = bytes;
  segment->device = status.st_dev;
  segment->inode = status.st_ino;
  const odom_status checked = check_header(segment);
  if (checked != ODOM_OK) odomi_detach(segment);
  return checked;
}

odom_status odomi_attach(const char* path, const odomi_owners* owners, const odomi_segment* known,
                         odomi_segment* segment) {
  memset(segment, 0, sizeof *segment);
  const int file = open(path, O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file < 0) return status_of_open_error();
  const odom_status status = map_file(file, owners, known, segment);
  const int error = errno;
  close(file);
  errno = error;
  return status;
}

void odomi_detach(odomi_segment* segment) {
  if (segment->memory != NULL) munmap(segment->memory, segment->bytes);
  memset(segment, 0, sizeof *segment);
}

void odomi_read_info(const odomi_segment* segment, odom_info* info) {
  odomi_copy_out(info, segment->words + ODOM_HEADER_INFO, ODOM_INFO_WORDS);
  info->model[ODOM_TEXT - 1] = '\0';
  info->version[ODOM_TEXT - 1] = '\0';
}
