/* The records that odomd publishes, as a client sees them. C11 and C++; libc types only.
 *
 * Frames and units: ISO 8855 (x forward, y left, yaw counter-clockwise), centre of gravity, SI
 * units, times in nanoseconds of CLOCK_MONOTONIC. Yaw is continuous (unwrapped).
 *
 * Every struct here is an array of 64-bit words (or pairs of 32-bit halves) without padding, in the
 * order of the words in a slot of the segment. The layout is append-only: fields are added at the
 * end of odom_details, never moved.
 */
#ifndef ODOM_TYPES_H
#define ODOM_TYPES_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The quality of the pose. When several modes apply, the first of this order:
 *  fault, initialising, degraded, standstill, dead_reckoning, tracking. */
typedef enum odom_mode {
  ODOM_INITIALISING = 0,   /**< no initial pose or no wheel speed yet: pose fields are not valid */
  ODOM_TRACKING = 1,       /**< camera poses are coming in */
  ODOM_DEAD_RECKONING = 2, /**< odometry alone */
  ODOM_DEGRADED = 3,       /**< works, but a condition bit says what is missing */
  ODOM_STANDSTILL = 4,     /**< the car is stationary */
  ODOM_FAULT = 5           /**< the pose is frozen or meaningless: do not drive by it */
} odom_mode;

/** Bits of odom_pose.conditions. */
enum {
  ODOM_COND_NOT_REALTIME = 1u << 0,    /**< the machine refused real-time scheduling or locking */
  ODOM_COND_RESTARTED = 1u << 1,       /**< resumed from its predecessor's last pose */
  ODOM_COND_BUS_DOWN = 1u << 2,        /**< a bus is down or gone */
  ODOM_COND_SIGNAL_TIMEOUT = 1u << 3,  /**< a mapped signal is overdue (see health) */
  ODOM_COND_PROTECTION = 1u << 4,      /**< a message fails its end-to-end protection */
  ODOM_COND_FRAMES_LOST = 1u << 5,     /**< the kernel dropped frames within the last second */
  ODOM_COND_CARRIED_OVER = 1u << 6,    /**< this tick left frames behind for the next */
  ODOM_COND_CLOCK_STEPPED = 1u << 7,   /**< the wall clock stepped within the last second */
  ODOM_COND_SUSPENDED = 1u << 8,       /**< the machine slept within the last second */
  ODOM_COND_CAMERA_REJECTED = 1u << 9, /**< the last camera pose was rejected */
  ODOM_COND_MODEL_FAULT = 1u << 10,    /**< the model left its domain and stopped */
  ODOM_COND_NON_FINITE = 1u << 11,     /**< a non-finite state was reset, never published */
  ODOM_COND_INPUT_ENDED = 1u << 12,    /**< the log or the pipe has ended */
  ODOM_COND_SENSOR_FAULT = 1u << 13,   /**< a sensor's values cannot be true (see health) */
  ODOM_COND_WHEEL_SLIP = 1u << 14,     /**< a wheel's speed does not fit the car's motion */
  ODOM_COND_MISWIRED = 1u << 15,       /**< a sensor is wired or described wrongly (see health) */
  ODOM_COND_INCONSISTENT = 1u << 16,   /**< a source does not fit the filter's prediction */
  ODOM_COND_BIAS_UNLEARNT = 1u << 17,  /**< the gyro's bias is unknown: stop for 2 s */
  ODOM_COND_SCALE_IMPLAUSIBLE = 1u << 18, /**< a learnt scale is far from its configured value */
  ODOM_COND_CAMERA_REFUSED = 1u << 19     /**< a camera connection was refused in the last 10 s */
};

/** Index of a source in health, source_age_ns and the status. Append-only. */
typedef enum odom_source {
  ODOM_SOURCE_YAW_RATE = 0,
  ODOM_SOURCE_ACCEL_X,
  ODOM_SOURCE_ACCEL_Y,
  ODOM_SOURCE_WHEEL_FRONT_LEFT,
  ODOM_SOURCE_WHEEL_FRONT_RIGHT,
  ODOM_SOURCE_WHEEL_REAR_LEFT,
  ODOM_SOURCE_WHEEL_REAR_RIGHT,
  ODOM_SOURCE_WHEEL_REAR,
  ODOM_SOURCE_MOTOR,
  ODOM_SOURCE_STEERING,
  ODOM_SOURCE_DIRECTION,
  ODOM_SOURCE_CAMERA,
  ODOM_SOURCE_COUNT,
  ODOM_SOURCE_CAPACITY = 16
} odom_source;

/** What a controller needs: 28 words. */
typedef struct odom_pose {
  uint64_t tick;   /**< number of the tick; strictly increasing */
  int64_t time_ns; /**< when the pose is valid, CLOCK_MONOTONIC */

  double x, y, yaw;                /**< map frame [m, m, rad]; jumps when reset_count rises */
  double odom_x, odom_y, odom_yaw; /**< jump-free odometry frame [m, m, rad] */

  double vx, vy, yaw_rate;          /**< body frame [m/s, m/s, rad/s] */
  double vx_dot, vy_dot, yaw_accel; /**< their time derivatives [m/s2, m/s2, rad/s2] */
  double accel_x, accel_y;          /**< measured specific force [m/s2] */
  double steering;                  /**< at the front wheels [rad], left positive */

  double covariance[6]; /**< of (x, y, yaw): xx, xy, xyaw, yy, yyaw, yawyaw */

  uint32_t mode;        /**< an odom_mode */
  uint32_t conditions;  /**< ODOM_COND_ bits */
  uint32_t reset_count; /**< times the map pose jumped */
  uint32_t health;      /**< bit s: odom_source s is configured and fine */

  double jump_x, jump_y, jump_yaw; /**< the last jump of the map pose, map axes */
} odom_pose;

/** All other results of a tick: for diagnosis, recording and users of the full state. */
typedef struct odom_details {
  double velocity_covariance[15]; /**< the rest of the upper triangle, by rows, of the 6x6
                                     covariance of (x, y, yaw, vx, vy, yaw_rate): x-vx, x-vy,
                                     x-yaw_rate, y-vx, ..., yaw-yaw_rate, vx-vx, vx-vy, vx-yaw_rate,
                                     vy-vy, vy-yaw_rate, yaw_rate-yaw_rate */

  double gyro_bias;            /**< [rad/s] */
  double gyro_scale;           /**< 1: exact */
  double accel_bias_x;         /**< [m/s2] */
  double accel_bias_y;         /**< [m/s2] */
  double wheel_scale;          /**< 1: exact */
  double steering_offset;      /**< [rad] */
  double stiffness_scale;      /**< 1: as configured */
  double calibration_sigma[7]; /**< standard deviations of the seven above; 0: not estimated */
  uint64_t calibration_valid;  /**< bit i: the i-th has been learnt; bits 7 to 10: the four at the
                                  end */

  double correction_x, correction_y, correction_yaw; /**< pose of the odometry frame in the map */

  int64_t dead_reckoning_since_ns; /**< time of the last fused camera pose; 0: none yet */

  int64_t source_age_ns[ODOM_SOURCE_CAPACITY]; /**< at time_ns; -1: never seen */
  uint64_t frames[8];                          /**< received since start, per bus */
  uint64_t camera_messages;                    /**< received since start */

  int64_t wakeup_latency_ns; /**< how late the beat woke for this tick */
  int64_t execution_ns;      /**< execution time of the previous tick */

  /* Since ABI 1.1. Latencies add to the configured ones; positive: the sensor is later. */
  double gyro_latency;                 /**< [s] */
  double wheel_latency;                /**< [s] */
  double steering_latency;             /**< [s] */
  double grip;                         /**< largest possible lateral acceleration [m/s2] */
  double further_calibration_sigma[4]; /**< standard deviations of the four above; 0: not
                                          estimated */
} odom_details;

/** Longest name of a model or version string, with its terminating zero. */
#define ODOM_TEXT 32

/** The constants of a running daemon, and the offsets of its clocks. */
typedef struct odom_info {
  uint32_t abi_major;
  uint32_t abi_minor;
  uint64_t instance_id; /**< differs for every start of a daemon */
  int64_t writer_pid;
  int64_t writer_start_ns; /**< CLOCK_MONOTONIC */
  int64_t period_ns;
  int64_t first_tick_ns;      /**< T_0: tick k is valid at first_tick_ns + k * period_ns */
  int64_t realtime_offset_ns; /**< CLOCK_REALTIME - CLOCK_MONOTONIC, as last measured */
  int64_t log_offset_ns;      /**< log clock - CLOCK_MONOTONIC; 0 where no log is played */
  uint64_t slots;             /**< length of the history, in ticks */
  double mass, front_axle, rear_axle, yaw_inertia;
  double cornering_stiffness_front, cornering_stiffness_rear, track_width;
  char model[ODOM_TEXT];   /**< "kinematic", "paper", ... */
  char version[ODOM_TEXT]; /**< of the daemon */
} odom_info;

/** Buckets of a beat histogram: bucket 0 counts [0, 1) us, bucket i >= 1 counts
 *  [2^((i-1)/4), 2^(i/4)) us, the last one everything above (about 46 ms). */
#define ODOM_HISTOGRAM_BUCKETS 64

/** Timing statistics of the beat since start. */
typedef struct odom_beat {
  uint64_t ticks;                    /**< published */
  uint64_t missed;                   /**< cycles of the grid that were skipped entirely */
  uint64_t overruns;                 /**< ticks that were not done when the next was due */
  uint64_t carried_over;             /**< drains that left frames behind */
  int64_t heartbeat_ns;              /**< CLOCK_MONOTONIC of the last tick */
  int64_t last_overrun_ns;           /**< time of the last overrun; 0: never */
  int64_t last_overrun_execution_ns; /**< its execution time: was it slow, or woken late? */
  int64_t max_wakeup_ns;
  int64_t max_execution_ns;
  uint64_t wakeup[ODOM_HISTOGRAM_BUCKETS];    /**< wake-up latency */
  uint64_t execution[ODOM_HISTOGRAM_BUCKETS]; /**< execution time of a tick */
} odom_beat;

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif
