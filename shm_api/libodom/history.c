/* The pose at a past time, from the ring of slots.
 *
 * Tick k lies in slot k modulo the number of slots, and is valid at T_0 + k * period: the
 * neighbours of a time are found by division. A missed tick leaves its slot unchanged, with an
 * older sequence, so the search continues with the next slot; it reads each slot at most once.
 *
 * Between its neighbours, dt apart, the position is the cubic with their positions and velocities
 * (Hermite's). On a path with v, w constant it is off by at most v w^3 dt^4 / 384: 10 nm for 2 m/s
 * and 3 rad/s at 5 ms, 15 um across a gap of 100 ms. All other fields are linear.
 *
 * When the map pose was reset between the neighbours, there is no path between them: the earlier
 * one is predicted up to the later one.
 */
#include <math.h>

#include <odom/odom.h>

#include "shm_api/layout/slot.h"
#include "shm_api/libodom/client.h"

static const int64_t longest_gap_ns = 100000000;

/* Copies tick k; true if it is (still) in its slot. A head of k or newer was acquired before. */
static int read_tick(const odomi_segment* segment, uint64_t k, odom_pose* pose) {
  const uint64_t* slot = odomi_slot(segment, k);
  odomi_copy_out(pose, slot + ODOM_SLOT_POSE, ODOM_POSE_WORDS);
  return odomi_still(slot, odomi_sequence(k));
}

static odom_status find_neighbours(odomi_segment* segment, int64_t time_ns, odom_pose* before,
                                   odom_pose* after) {
  odom_pose newest;
  const odom_status status = odomi_newest(segment, &newest, NULL);
  if (status != ODOM_OK) return status;
  if (time_ns > newest.time_ns) return ODOM_TOO_NEW;

  const uint64_t period = (uint64_t)segment->period_ns;
  const uint64_t distance = (uint64_t)newest.time_ns - (uint64_t)time_ns;
  const uint64_t back = distance / period + (distance % period != 0);
  const uint64_t oldest = newest.tick > segment->slot_mask ? newest.tick - segment->slot_mask : 0;
  if (back > newest.tick - oldest) return ODOM_TOO_OLD;

  uint64_t k = newest.tick - back;
  while (!read_tick(segment, k, before) || before->time_ns > time_ns)
    if (k-- == oldest) return ODOM_TOO_OLD;

  *after = *before;
  while (after->time_ns < time_ns) {
    do
      if (k++ == newest.tick) return ODOM_TOO_OLD; /* the writer has overtaken the search */
    while (!read_tick(segment, k, after));
    if (after->time_ns <= time_ns) *before = *after;
  }
  return ODOM_OK;
}

typedef struct {
  double x, y, yaw;
} planar;

static double mix(double a, double b, double s) {
  return a + s * (b - a);
}

/* Cubic Hermite interpolation, s in [0, 1], slopes in units per interval. */
static double hermite(double a, double slope_a, double b, double slope_b, double s) {
  const double r = 1.0 - s;
  return r * r * (1.0 + 2.0 * s) * a + s * s * (1.0 + 2.0 * r) * b +
         s * r * (r * slope_a - s * slope_b);
}

/* Slopes: x' = v_x cos(yaw) - v_y sin(yaw), y' = v_x sin(yaw) + v_y cos(yaw), at both ends. */
static planar between(planar a, const odom_pose* motion_a, planar b, const odom_pose* motion_b,
                      double s, double dt) {
  const double cos_a = cos(a.yaw), sin_a = sin(a.yaw);
  const double cos_b = cos(b.yaw), sin_b = sin(b.yaw);
  planar p;
  p.x = hermite(a.x, dt * (motion_a->vx * cos_a - motion_a->vy * sin_a), b.x,
                dt * (motion_b->vx * cos_b - motion_b->vy * sin_b), s);
  p.y = hermite(a.y, dt * (motion_a->vx * sin_a + motion_a->vy * cos_a), b.y,
                dt * (motion_b->vx * sin_b + motion_b->vy * cos_b), s);
  p.yaw = a.yaw + s * remainder(b.yaw - a.yaw, 6.283185307179586477);
  return p;
}

static odom_pose interpolate(const odom_pose* a, const odom_pose* b, int64_t time_ns) {
  const double span_ns = (double)(b->time_ns - a->time_ns);
  const double s = (double)(time_ns - a->time_ns) / span_ns;
  const double dt = span_ns * 1e-9;
  odom_pose p = *a;
  p.time_ns = time_ns;

  const planar map =
      between((planar){a->x, a->y, a->yaw}, a, (planar){b->x, b->y, b->yaw}, b, s, dt);
  p.x = map.x;
  p.y = map.y;
  p.yaw = map.yaw;
  const planar odom = between((planar){a->odom_x, a->odom_y, a->odom_yaw}, a,
                              (planar){b->odom_x, b->odom_y, b->odom_yaw}, b, s, dt);
  p.odom_x = odom.x;
  p.odom_y = odom.y;
  p.odom_yaw = odom.yaw;

  p.vx = mix(a->vx, b->vx, s);
  p.vy = mix(a->vy, b->vy, s);
  p.yaw_rate = mix(a->yaw_rate, b->yaw_rate, s);
  p.vx_dot = mix(a->vx_dot, b->vx_dot, s);
  p.vy_dot = mix(a->vy_dot, b->vy_dot, s);
  p.yaw_accel = mix(a->yaw_accel, b->yaw_accel, s);
  p.accel_x = mix(a->accel_x, b->accel_x, s);
  p.accel_y = mix(a->accel_y, b->accel_y, s);
  p.steering = mix(a->steering, b->steering, s);
  /* A mean of two positive semi-definite matrices is positive semi-definite. */
  for (int i = 0; i < 6; ++i) p.covariance[i] = mix(a->covariance[i], b->covariance[i], s);
  return p;
}

odom_status odom_at(odom_client* client, int64_t time_ns, odom_pose* pose, size_t size) {
  if (client == NULL || pose == NULL || !odomi_is_size(size)) return ODOM_INVALID;
  const odom_status freshness = odomi_freshen(client);
  odom_pose before;
  odom_pose after;
  const odom_status status = find_neighbours(&client->segment, time_ns, &before, &after);
  if (status != ODOM_OK) return status;

  odom_pose result = before;
  if (time_ns != before.time_ns) {
    if (after.time_ns - before.time_ns > longest_gap_ns) return ODOM_GAP;
    if (before.reset_count == after.reset_count)
      result = interpolate(&before, &after, time_ns);
    else if (odom_predict(&before, time_ns, &result) != ODOM_OK)
      return ODOM_RESET; /* `before` is initialising */
  }
  odomi_give(pose, size, &result, sizeof result);
  return freshness;
}
