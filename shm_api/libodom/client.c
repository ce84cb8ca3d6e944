/* Opens and closes a client, checks whether the writer is alive, and switches to its successor. */
#include "shm_api/libodom/client.h"

#include <errno.h>
#include <pwd.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <odom/odom.h>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/service.h"

static const char service_user[] = "odomd";

/* Root, the caller, and the user of the service if it exists. */
static odomi_owners trusted_owners(void) {
  odomi_owners owners = {{0, geteuid()}, 2};
  char buffer[4096];
  struct passwd entry;
  struct passwd* found = NULL;
  if (getpwnam_r(service_user, &entry, buffer, sizeof buffer, &found) == 0 && found != NULL)
    owners.uid[owners.count++] = found->pw_uid;
  return owners;
}

static void adopt(odom_client* client, const odomi_segment* segment) {
  struct timespec tick = {0, 0};
  clock_getres(CLOCK_MONOTONIC_COARSE, &tick);
  client->segment = *segment;
  client->stale_after_ns = ODOM_STALE_PERIODS * segment->period_ns;
  client->clearly_fresh_ns = client->stale_after_ns - tick.tv_sec * 1000000000 - tick.tv_nsec;
}

static void look_for_successor(odom_client* client) {
  for (size_t i = 0; i < 2 && client->paths[i] != NULL; ++i) {
    odomi_segment found;
    if (odomi_attach(client->paths[i], &client->owners, &client->segment, &found) != ODOM_OK ||
        found.words == NULL)
      continue;
    /* Until the successor has published, keep the last pose of its predecessor. */
    if (found.instance_id != client->segment.instance_id && odomi_read_head(found.words) != 0 &&
        odomi_is_fresh(&found, odomi_now(CLOCK_MONOTONIC), ODOM_STALE_PERIODS * found.period_ns)) {
      odomi_detach(&client->segment);
      adopt(client, &found);
      return;
    }
    odomi_detach(&found);
  }
}

odom_status odomi_look_again(odom_client* client) {
  int64_t now_ns = odomi_now(CLOCK_MONOTONIC);
  if (odomi_is_fresh(&client->segment, now_ns, client->stale_after_ns)) return ODOM_OK;

  if (now_ns < client->next_attempt_ns) return ODOM_STALE;
  client->next_attempt_ns = now_ns + client->stale_after_ns;
  const int error = errno;
  look_for_successor(client);
  errno = error;
  now_ns = odomi_now(CLOCK_MONOTONIC);
  return odomi_is_fresh(&client->segment, now_ns, client->stale_after_ns) ? ODOM_OK : ODOM_STALE;
}

/* The candidates: the name from the caller or the environment; without one, the two places of
 * odomd's segment: started by hand, and as a service. */
static odom_status candidate_paths(const char* name, char* paths[2]) {
  if (name == NULL) {
    name = secure_getenv("ODOM_SHM");
    if (name != NULL && name[0] == '\0') name = NULL;
  }
  if (name != NULL) return odomi_path(name, &paths[0]);
  const odom_status status = odomi_path("/odomd", &paths[0]);
  return status == ODOM_OK ? odomi_service_path(ODOMI_SERVICE_DIRECTORY, "pose", &paths[1])
                           : status;
}

/* Attaches to the first segment with a living writer; without one, to the first that exists. */
static odom_status attach_first(odom_client* client) {
  odom_status failure = ODOM_NO_SEGMENT;
  for (size_t i = 0; i < 2 && client->paths[i] != NULL; ++i) {
    odomi_segment found;
    const odom_status status = odomi_attach(client->paths[i], &client->owners, NULL, &found);
    if (status != ODOM_OK) {
      if (failure == ODOM_NO_SEGMENT) failure = status;
      continue;
    }
    const int fresh =
        odomi_is_fresh(&found, odomi_now(CLOCK_MONOTONIC), ODOM_STALE_PERIODS * found.period_ns);
    if (!fresh && client->segment.words != NULL) {
      odomi_detach(&found);
      continue;
    }
    odomi_detach(&client->segment);
    adopt(client, &found);
    if (fresh) break;
  }
  return client->segment.words != NULL ? ODOM_OK : failure;
}

odom_status odom_open(const char* name, odom_client** client) {
  if (client == NULL) return ODOM_INVALID;
  *client = NULL;
  odom_client* opened = calloc(1, sizeof *opened);
  if (opened == NULL) return ODOM_SYSTEM;
  opened->owners = trusted_owners();
  odom_status status = candidate_paths(name, opened->paths);
  if (status == ODOM_OK) status = attach_first(opened);
  if (status != ODOM_OK) {
    const int error = errno;
    odom_close(opened);
    errno = error;
    return status;
  }
  *client = opened;
  return ODOM_OK;
}

void odom_close(odom_client* client) {
  if (client == NULL) return;
  odomi_detach(&client->segment);
  free(client->paths[0]);
  free(client->paths[1]);
  free(client);
}

const char* odom_strstatus(odom_status status) {
  static const char* const texts[] = {
      [ODOM_OK] = "ok",
      [ODOM_STALE] = "stale: odomd has not ticked for four periods",
      [ODOM_NO_SEGMENT] = "no such segment: is odomd running?",
      [ODOM_REFUSED] = "segment refused: untrusted owner, writable by others, or not readable",
      [ODOM_ABI] = "not a segment, or another ABI version: do libodom and odomd match?",
      [ODOM_NO_POSE] = "no pose yet",
      [ODOM_TOO_OLD] = "the time is before the history",
      [ODOM_TOO_NEW] = "the time is too far ahead",
      [ODOM_RESET] = "the pose was reset around that time",
      [ODOM_TIMEOUT] = "timed out",
      [ODOM_BUSY] = "overtaken by the writer: the reader was stopped for seconds",
      [ODOM_INVALID] = "an argument is invalid",
      [ODOM_GAP] = "odomd missed its ticks around that time",
      [ODOM_SYSTEM] = "a system call failed",
  };
  const size_t index = (size_t)status;
  return index < sizeof texts / sizeof *texts ? texts[index] : "unknown status";
}
