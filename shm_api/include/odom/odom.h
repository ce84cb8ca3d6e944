/* libodom: read the car's pose from odomd's shared memory. C, depends on libc and libm alone.
 *
 *   odom_client *client;
 *   if (odom_open(NULL, &client) != ODOM_OK) ...
 *   odom_pose pose;
 *   pose.tick = 0;
 *   while (odom_wait(client, &pose, sizeof pose, 100000000) == ODOM_OK)
 *     if (pose.mode != ODOM_INITIALISING && pose.mode != ODOM_FAULT &&
 *         odom_position_sigma(&pose) <= lane)
 *       steer_by(&pose);
 *   odom_close(client);
 *
 * A client maps the segment read-only, never writes, never spins without bound, and survives the
 * end and the restart of the daemon at any time: a call then returns ODOM_STALE. As soon as a new
 * daemon publishes, the same client re-attaches by itself and returns ODOM_OK again (with another
 * odom_info.instance_id).
 *
 * Thread-safety: one odom_client belongs to one thread at a time; open one for each thread. After a
 * fork, parent and child each have a client, to be used and closed independently; the connection of
 * an odom_camera would be shared, so open it after the fork. The library has no global state. Every
 * call except odom_open, odom_wait and re-attachment (at most once in four periods, only when
 * stale) is lock-free and makes no system call (the vDSO reads the clock).
 *
 * ODOM_STALE always comes with a result: the daemon's last. All other codes except ODOM_OK leave
 * the caller's memory unchanged; after ODOM_BUSY the pose and the details may be zero, with mode
 * ODOM_FAULT.
 *
 * Structs are passed with their size, so that a program built against an older libodom keeps
 * working with a newer one.
 */
#ifndef ODOM_ODOM_H
#define ODOM_ODOM_H

/* C that C++ reads too. NOLINTBEGIN(modernize-*) */

#include <stddef.h>
#include <stdint.h>

#include <odom/types.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum odom_status {
  ODOM_OK = 0,
  ODOM_STALE = 1, /**< the daemon has not ticked for four periods; the last pose is still given */
  ODOM_NO_SEGMENT = 2, /**< no such segment: is the daemon running? */
  ODOM_REFUSED = 3,    /**< the segment has an untrusted owner, or is not readable */
  ODOM_ABI = 4,        /**< written by a daemon of another ABI major, or not a segment at all */
  ODOM_NO_POSE = 5,    /**< attached, but nothing has been published yet */
  ODOM_TOO_OLD = 6,    /**< the time is before the history */
  ODOM_TOO_NEW = 7,    /**< the time lies ahead of the newest pose, or of what may be predicted */
  ODOM_RESET = 8,      /**< the time falls between an initialising pose and a reset */
  ODOM_TIMEOUT = 9,
  ODOM_BUSY = 10,    /**< overtaken by the writer three times: the caller was stopped for seconds */
  ODOM_INVALID = 11, /**< an argument is invalid */
  ODOM_GAP = 12,     /**< the daemon missed more than 100 ms of ticks around the time */
  ODOM_SYSTEM = 13   /**< the system refused memory, a file or a mapping: see errno */
} odom_status;

typedef struct odom_client odom_client;

/** The name of a status, for messages: "no such segment: is odomd running?". Never NULL. */
const char* odom_strstatus(odom_status status);

/** Attaches to a segment: a POSIX shm name ("/odomd") or a path. NULL: $ODOM_SHM; if that is not
 * set, "/odomd" or the service's segment, the first of the two whose daemon is running. The
 * service's segment is "/run/odomd/INTERFACE/pose" of its first interface by name ("can0"), or
 * "/run/odomd/pose" without one. Refuses segments of owners other than root, the service's user
 * "odomd" and the caller, and files that others may write. `*client` is NULL unless the result is
 * ODOM_OK. The segment of a daemon that has ended can be opened: its poses are stale. */
odom_status odom_open(const char* name, odom_client** client);
void odom_close(odom_client* client);

/** Copies the newest pose. ODOM_OK or ODOM_STALE: `pose` is complete. */
odom_status odom_latest(odom_client* client, odom_pose* pose, size_t size);

/** Copies the newest pose and the details of the same tick. */
odom_status odom_latest_details(odom_client* client, odom_pose* pose, size_t pose_size,
                                odom_details* details, size_t details_size);

/** The pose at a past time within the history, interpolated between its neighbours (yaw the shorter
 * way), but never across a gap of more than 100 ms (ODOM_GAP) nor across a reset: if reset_count
 * differs between the neighbours, the earlier one is predicted to the time as with odom_predict();
 * ODOM_RESET if it is initialising. Fields such as mode are those of the earlier neighbour. The
 * error of the interpolation is below a micrometre between ticks, and tens of micrometres across a
 * gap (see docs/shm.md). Reads each slot of the history at most once. */
odom_status odom_at(odom_client* client, int64_t time_ns, odom_pose* pose, size_t size);

/** Predicts `from` to `time_ns`, at most 100 ms ahead (ODOM_TOO_NEW; before `from`: ODOM_TOO_OLD),
 *  with constant derivatives of its velocities: position, yaw and velocities are exact to a
 * micrometre for that motion, and the covariance grows. All other fields are those of `from`. An
 * initialising pose cannot be predicted (ODOM_NO_POSE). Pure: needs no client. `to` may be `from`.
 */
odom_status odom_predict(const odom_pose* from, int64_t time_ns, odom_pose* to);

/** Sleeps until a pose newer than `pose` (from an earlier call) is published, by this daemon or by
 * its successor, and copies it; with pose->tick == 0 it waits for the next one. `timeout_ns` < 0: a
 * second. ODOM_OK: a newer pose. ODOM_STALE: timed out, the daemon is silent, and `pose` is its
 * last pose. ODOM_TIMEOUT: timed out, `pose` is unchanged. */
odom_status odom_wait(odom_client* client, odom_pose* pose, size_t size, int64_t timeout_ns);

/** The name of odom_pose.mode, for messages: "dead_reckoning", as in the status; "unknown" for a
 * value that is no odom_mode. Never NULL. Needs no client. */
const char* odom_mode_name(uint32_t mode);

/** Standard deviation of the position in the direction in which it is largest [m]: the root of the
 * larger eigenvalue of the covariance of x and y. NaN if the covariance is invalid, so write
 * `sigma <= limit`, which is then false. Meaningless for an initialising pose. Pure: needs no
 * client. */
double odom_position_sigma(const odom_pose* pose);

/** The header. Each field is consistent, but two fields may be of different instants. */
odom_status odom_get_info(odom_client* client, odom_info* info, size_t size);
odom_status odom_get_beat(odom_client* client, odom_beat* beat, size_t size);

/* In place (zero copy) --------------------------------------------------------------------------
 *
 *   odom_view view;
 *   do {
 *     if (odom_begin(client, &view) != ODOM_OK) ...
 *     x = odom_view_double(&view, ODOM_WORD_X);
 *   } while (!odom_validate(&view));
 *
 * The words are read in place. They are valid only after odom_validate() has returned true. A view
 * is valid until the next call with the same client. A daemon of an older odom_info.abi_minor does
 * not have the fields that odom_details has gained since: do not read these words then.
 */
typedef struct odom_view {
  const uint64_t* words; /**< of the slot; words[0] is its sequence. Read by the accessors only. */
  uint64_t sequence;
} odom_view;

/** Positions of the fields of odom_pose in a slot, in words. */
enum {
  ODOM_WORD_TICK = 1,
  ODOM_WORD_TIME,
  ODOM_WORD_X,
  ODOM_WORD_Y,
  ODOM_WORD_YAW,
  ODOM_WORD_ODOM_X,
  ODOM_WORD_ODOM_Y,
  ODOM_WORD_ODOM_YAW,
  ODOM_WORD_VX,
  ODOM_WORD_VY,
  ODOM_WORD_YAW_RATE,
  ODOM_WORD_VX_DOT,
  ODOM_WORD_VY_DOT,
  ODOM_WORD_YAW_ACCEL,
  ODOM_WORD_ACCEL_X,
  ODOM_WORD_ACCEL_Y,
  ODOM_WORD_STEERING,
  ODOM_WORD_COVARIANCE,
  ODOM_WORD_MODE = ODOM_WORD_COVARIANCE + 6, /* low half: mode, high half: conditions */
  ODOM_WORD_RESETS,                          /* low half: reset_count, high half: health */
  ODOM_WORD_JUMP_X,
  ODOM_WORD_JUMP_Y,
  ODOM_WORD_JUMP_YAW,
  ODOM_WORD_DETAILS /* where odom_details begins */
};

/** A view of the newest pose. ODOM_OK, ODOM_STALE: `view` is set; ODOM_NO_POSE. */
odom_status odom_begin(odom_client* client, odom_view* view);

static inline uint64_t odom_view_word(const odom_view* view, size_t word) {
  return __atomic_load_n(&view->words[word], __ATOMIC_RELAXED);
}

static inline double odom_view_double(const odom_view* view, size_t word) {
  const uint64_t bits = odom_view_word(view, word);
  double value = 0.0;
  __builtin_memcpy(&value, &bits, sizeof value);
  return value;
}

/** Whether everything read through the view since odom_begin() belongs to one published pose. */
static inline int odom_validate(const odom_view* view) {
  __atomic_thread_fence(__ATOMIC_ACQUIRE);
  return __atomic_load_n(&view->words[0], __ATOMIC_RELAXED) == view->sequence ? 1 : 0;
}

/* Clocks
 * ------------------------------------------------------------------------------------------*/

typedef enum odom_clock {
  ODOM_CLOCK_MONOTONIC = 0,
  ODOM_CLOCK_REALTIME = 1,
  ODOM_CLOCK_LOG = 2 /**< the stamps of the log that the daemon plays */
} odom_clock;

/** Converts a CLOCK_MONOTONIC time to another clock, with the offsets in the segment. ODOM_INVALID
 * for ODOM_CLOCK_LOG when no log is played. */
odom_status odom_to_clock(odom_client* client, odom_clock clock, int64_t monotonic_ns,
                          int64_t* time_ns);

/* Sending camera poses
 * -------------------------------------------------------------------------------*/

/** One camera pose on the wire: 80 bytes, little-endian, one SOCK_SEQPACKET message each. */
typedef struct odom_camera_message {
  uint32_t magic;                     /**< ODOM_CAMERA_MAGIC */
  uint16_t version;                   /**< ODOM_CAMERA_VERSION */
  uint16_t clock;                     /**< an odom_clock: the clock of capture_ns */
  uint64_t sequence;                  /**< the sender's own count, rising */
  int64_t capture_ns;                 /**< when the picture was taken */
  double x, y, yaw;                   /**< of the reference point, map frame [m, m, rad] */
  double sigma_x, sigma_y, sigma_yaw; /**< standard deviations, map axes [m, m, rad] */
  uint64_t reserved;                  /**< 0 */
} odom_camera_message;

#define ODOM_CAMERA_MAGIC 0x4D43444Fu /* "ODCM" */
#define ODOM_CAMERA_VERSION 1

typedef struct odom_camera odom_camera;

/** Connects to the daemon's camera socket. NULL: "$XDG_RUNTIME_DIR/odomd/camera.sock" if a process
 * serves it, otherwise "/run/odomd/INTERFACE/camera.sock" of the service's first interface by name,
 * or "/run/odomd/camera.sock" without one. 0, or a negative errno. */
int odom_camera_open(const char* path, odom_camera** camera);

/** Sends one pose (magic, version, sequence and reserved are filled in). Never blocks; reconnects
 * by itself when the daemon was restarted. 0, or a negative errno (-EAGAIN: the daemon does not
 * keep up; -ECONNREFUSED, -ENOENT: it is not running; -EBUSY, -EACCES: it refused the previous
 * connection, because all are taken or the user may not send; -EINVAL: not finite, a sigma that is
 * not positive, or an unknown clock); on an error the pose is dropped. */
int odom_camera_send(odom_camera* camera, const odom_camera_message* message);

/** Waits at most `timeout_ns` until the daemon has read what was sent. 0, or a negative errno as
 * from odom_camera_send(); -EAGAIN also when the time is over. For a program that sends one pose,
 * or that wants to know at its start whether it is admitted. */
int odom_camera_flush(odom_camera* camera, int64_t timeout_ns);
void odom_camera_close(odom_camera* camera);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif
