/* Reads the newest pose, copied or in place, and the header. */
#include <string.h>

#include <odom/odom.h>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/client.h"

static size_t smaller(size_t a, size_t b) {
  return a < b ? a : b;
}

/* Reads directly into the caller's memory: an extra copy would cost more than the read. When the
 * writer has overtaken all attempts, the memory has a mixture of poses, which must not be used as a
 * pose. */
odom_status odomi_newest(odomi_segment* segment, odom_pose* pose, odom_details* details) {
  const size_t details_words = smaller(segment->details_words, ODOM_DETAILS_WORDS);
  for (int attempt = 0; attempt < ODOMI_ATTEMPTS; ++attempt) {
    const uint64_t head = odomi_read_head(segment->words);
    if (head == 0) return ODOM_NO_POSE;
    const uint64_t* slot = odomi_head_slot(segment, head);
    odomi_copy_out(pose, slot + ODOM_SLOT_POSE, ODOM_POSE_WORDS);
    if (details != NULL) odomi_copy_out(details, slot + ODOM_SLOT_DETAILS, details_words);
    if (!odomi_still(slot, head)) continue;
    /* A daemon of an older ABI minor has fewer details: set the others to zero. */
    if (details != NULL && details_words < ODOM_DETAILS_WORDS)
      memset((char*)details + 8 * details_words, 0, 8 * (ODOM_DETAILS_WORDS - details_words));
    return ODOM_OK;
  }
  *pose = (odom_pose){.mode = ODOM_FAULT};
  if (details != NULL) *details = (odom_details){0};
  return ODOM_BUSY;
}

odom_status odom_latest(odom_client* client, odom_pose* pose, size_t size) {
  if (client == NULL || pose == NULL || !odomi_is_size(size)) return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  if (size == sizeof *pose) {
    const odom_status status = odomi_newest(&client->segment, pose, NULL);
    return status == ODOM_OK ? freshness : status;
  }
  odom_pose whole;
  const odom_status status = odomi_newest(&client->segment, &whole, NULL);
  if (status != ODOM_OK) return status;
  odomi_give(pose, size, &whole, sizeof whole);
  return freshness;
}

odom_status odom_latest_details(odom_client* client, odom_pose* pose, size_t pose_size,
                                odom_details* details, size_t details_size) {
  if (client == NULL || pose == NULL || details == NULL || !odomi_is_size(pose_size) ||
      !odomi_is_size(details_size))
    return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  if (pose_size == sizeof *pose && details_size == sizeof *details) {
    const odom_status status = odomi_newest(&client->segment, pose, details);
    return status == ODOM_OK ? freshness : status;
  }
  odom_pose whole_pose;
  odom_details whole_details;
  const odom_status status = odomi_newest(&client->segment, &whole_pose, &whole_details);
  if (status != ODOM_OK) return status;
  odomi_give(pose, pose_size, &whole_pose, sizeof whole_pose);
  odomi_give(details, details_size, &whole_details, sizeof whole_details);
  return freshness;
}

odom_status odom_begin(odom_client* client, odom_view* view) {
  if (client == NULL || view == NULL) return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  const uint64_t head = odomi_read_head(client->segment.words);
  if (head == 0) return ODOM_NO_POSE;
  view->words = odomi_head_slot(&client->segment, head);
  view->sequence = head;
  return freshness;
}

odom_status odom_get_info(odom_client* client, odom_info* info, size_t size) {
  if (client == NULL || info == NULL || !odomi_is_size(size)) return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  odom_info whole;
  odomi_read_info(&client->segment, &whole);
  odomi_give(info, size, &whole, sizeof whole);
  return freshness;
}

odom_status odom_get_beat(odom_client* client, odom_beat* beat, size_t size) {
  if (client == NULL || beat == NULL || !odomi_is_size(size)) return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  odom_beat whole;
  odomi_copy_out(&whole, client->segment.words + ODOM_HEADER_BEAT, ODOM_BEAT_WORDS);
  odomi_give(beat, size, &whole, sizeof whole);
  return freshness;
}

odom_status odom_to_clock(odom_client* client, odom_clock clock, int64_t monotonic_ns,
                          int64_t* time_ns) {
  if (client == NULL || time_ns == NULL) return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  const uint64_t* words = client->segment.words;
  int64_t offset_ns = 0;
  switch (clock) {
    case ODOM_CLOCK_MONOTONIC:
      break;
    case ODOM_CLOCK_REALTIME:
      offset_ns = (int64_t)odomi_load(words + ODOM_HEADER_REALTIME_OFFSET);
      break;
    case ODOM_CLOCK_LOG:
      offset_ns = (int64_t)odomi_load(words + ODOM_HEADER_LOG_OFFSET);
      if (offset_ns == 0) return ODOM_INVALID; /* no log is played */
      break;
    default:
      return ODOM_INVALID;
  }
  int64_t converted_ns = 0;
  if (__builtin_add_overflow(monotonic_ns, offset_ns, &converted_ns)) return ODOM_INVALID;
  *time_ns = converted_ns;
  return freshness;
}
