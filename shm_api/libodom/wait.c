/* Sleeps until the next pose. */
#include <errno.h>
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <odom/odom.h>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/client.h"

/* Sleeps while the futex word is `seen`, at most `timeout_ns`. A shared futex works on a
 * read-only mapping: the kernel finds the waiters by the page of the file. */
static void sleep_while(const odomi_segment* segment, uint32_t seen, int64_t timeout_ns) {
  const struct timespec timeout = {timeout_ns / 1000000000, timeout_ns % 1000000000};
  const uint64_t* futex = segment->words + ODOM_HEADER_FUTEX;
  if (syscall(SYS_futex, futex, FUTEX_WAIT, seen, &timeout, NULL, 0) == 0) return;
  if (errno == EAGAIN || errno == EINTR || errno == ETIMEDOUT) return;
  /* No futex (in a sandbox): check again in a millisecond. */
  const struct timespec pause = {0, timeout_ns < 1000000 ? timeout_ns : 1000000};
  nanosleep(&pause, NULL);
}

/* Acquire: after this load, the poses of all wake-ups counted in this word are visible. */
static uint32_t wakeups(const odomi_segment* segment) {
  return (uint32_t)__atomic_load_n(segment->words + ODOM_HEADER_FUTEX, __ATOMIC_ACQUIRE);
}

odom_status odom_wait(odom_client* client, odom_pose* pose, size_t size, int64_t timeout_ns) {
  if (client == NULL || pose == NULL || size < offsetof(odom_pose, x) || !odomi_is_size(size))
    return ODOM_INVALID;
  if (timeout_ns < 0) timeout_ns = 1000000000;
  const int error = errno;
  const int64_t start_ns = odomi_now(CLOCK_MONOTONIC);

  /* Newer by time, not by tick: a restarted daemon restarts its tick count. */
  odom_pose newest;
  int64_t last_ns = INT64_MIN;
  if (pose->tick != 0)
    last_ns = pose->time_ns;
  else if (odomi_newest(&client->segment, &newest, NULL) == ODOM_OK)
    last_ns = newest.time_ns;

  odom_status result = ODOM_TIMEOUT;
  for (;;) {
    const odom_status freshness = odomi_freshen(client);
    const uint32_t seen = wakeups(&client->segment);
    const odom_status status = odomi_newest(&client->segment, &newest, NULL);
    const int64_t left_ns = timeout_ns - (odomi_now(CLOCK_MONOTONIC) - start_ns);
    if (status == ODOM_OK && newest.time_ns > last_ns)
      result = freshness;
    else if (left_ns > 0) {
      /* Nobody wakes the clients of a dead writer: check once in four periods. */
      sleep_while(&client->segment, seen,
                  left_ns < client->stale_after_ns ? left_ns : client->stale_after_ns);
      continue;
    } else if (freshness == ODOM_STALE)
      result = status == ODOM_OK ? ODOM_STALE : status;
    break;
  }
  errno = error;
  if (result <= ODOM_STALE) odomi_give(pose, size, &newest, sizeof newest);
  return result;
}
