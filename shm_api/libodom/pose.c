/* What a controller checks before it drives by a pose: its mode by name, and its uncertainty. */
#include <math.h>

#include <odom/odom.h>

const char* odom_mode_name(uint32_t mode) {
  static const char* const names[] = {
      [ODOM_INITIALISING] = "initialising",     [ODOM_TRACKING] = "tracking",
      [ODOM_DEAD_RECKONING] = "dead_reckoning", [ODOM_DEGRADED] = "degraded",
      [ODOM_STANDSTILL] = "standstill",         [ODOM_FAULT] = "fault",
  };
  return mode < sizeof names / sizeof *names ? names[mode] : "unknown";
}

/* The root of the larger eigenvalue of [xx xy; xy yy]. */
double odom_position_sigma(const odom_pose* pose) {
  const double xx = pose->covariance[0], xy = pose->covariance[1], yy = pose->covariance[3];
  return sqrt(0.5 * (xx + yy) + hypot(0.5 * (xx - yy), xy));
}
