/* The layout for programs that were built years ago: fields with their offsets, constants with
 * their values. Nothing here ever changes: append, and raise the ABI's minor version. */
#ifndef ODOMD_TESTS_SHM_API_PINNED_LAYOUT_H
#define ODOMD_TESTS_SHM_API_PINNED_LAYOUT_H

/* clang-format off */
#define PINNED_STRUCTS(X) \
  X(odom_pose, 224, PINNED_POSE) X(odom_details, 552, PINNED_DETAILS) \
  X(odom_info, 192, PINNED_INFO) X(odom_beat, 1096, PINNED_BEAT) \
  X(odom_camera_message, 80, PINNED_CAMERA_MESSAGE)
#define PINNED_POSE(X) \
  X(tick, 0) X(time_ns, 8) X(x, 16) X(y, 24) X(yaw, 32) X(odom_x, 40) X(odom_y, 48) \
  X(odom_yaw, 56) X(vx, 64) X(vy, 72) X(yaw_rate, 80) X(vx_dot, 88) X(vy_dot, 96) \
  X(yaw_accel, 104) X(accel_x, 112) X(accel_y, 120) X(steering, 128) X(covariance, 136) \
  X(mode, 184) X(conditions, 188) X(reset_count, 192) X(health, 196) X(jump_x, 200) \
  X(jump_y, 208) X(jump_yaw, 216)
#define PINNED_DETAILS(X) \
  X(velocity_covariance, 0) X(gyro_bias, 120) X(gyro_scale, 128) X(accel_bias_x, 136) \
  X(accel_bias_y, 144) X(wheel_scale, 152) X(steering_offset, 160) X(stiffness_scale, 168) \
  X(calibration_sigma, 176) X(calibration_valid, 232) X(correction_x, 240) X(correction_y, 248) \
  X(correction_yaw, 256) X(dead_reckoning_since_ns, 264) X(source_age_ns, 272) X(frames, 400) \
  X(camera_messages, 464) X(wakeup_latency_ns, 472) X(execution_ns, 480) X(gyro_latency, 488) \
  X(wheel_latency, 496) X(steering_latency, 504) X(grip, 512) X(further_calibration_sigma, 520)
#define PINNED_INFO(X) \
  X(abi_major, 0) X(abi_minor, 4) X(instance_id, 8) X(writer_pid, 16) X(writer_start_ns, 24) \
  X(period_ns, 32) X(first_tick_ns, 40) X(realtime_offset_ns, 48) X(log_offset_ns, 56) \
  X(slots, 64) X(mass, 72) X(front_axle, 80) X(rear_axle, 88) X(yaw_inertia, 96) \
  X(cornering_stiffness_front, 104) X(cornering_stiffness_rear, 112) X(track_width, 120) \
  X(model, 128) X(version, 160)
#define PINNED_BEAT(X) \
  X(ticks, 0) X(missed, 8) X(overruns, 16) X(carried_over, 24) X(heartbeat_ns, 32) \
  X(last_overrun_ns, 40) X(last_overrun_execution_ns, 48) X(max_wakeup_ns, 56) \
  X(max_execution_ns, 64) X(wakeup, 72) X(execution, 584)
#define PINNED_CAMERA_MESSAGE(X) \
  X(magic, 0) X(version, 4) X(clock, 6) X(sequence, 8) X(capture_ns, 16) X(x, 24) X(y, 32) \
  X(yaw, 40) X(sigma_x, 48) X(sigma_y, 56) X(sigma_yaw, 64) X(reserved, 72)
#define PINNED_CONSTANTS(X) \
  X(INITIALISING, 0) X(TRACKING, 1) X(DEAD_RECKONING, 2) X(DEGRADED, 3) X(STANDSTILL, 4) \
  X(FAULT, 5) X(COND_NOT_REALTIME, 1) X(COND_RESTARTED, 2) X(COND_BUS_DOWN, 4) \
  X(COND_SIGNAL_TIMEOUT, 8) X(COND_PROTECTION, 16) X(COND_FRAMES_LOST, 32) \
  X(COND_CARRIED_OVER, 64) X(COND_CLOCK_STEPPED, 128) X(COND_SUSPENDED, 256) \
  X(COND_CAMERA_REJECTED, 512) X(COND_MODEL_FAULT, 1024) X(COND_NON_FINITE, 2048) \
  X(COND_INPUT_ENDED, 4096) X(COND_SENSOR_FAULT, 8192) X(COND_WHEEL_SLIP, 16384) \
  X(COND_MISWIRED, 32768) X(COND_INCONSISTENT, 65536) X(COND_BIAS_UNLEARNT, 131072) \
  X(COND_SCALE_IMPLAUSIBLE, 262144) X(COND_CAMERA_REFUSED, 524288) X(SOURCE_YAW_RATE, 0) \
  X(SOURCE_ACCEL_X, 1) X(SOURCE_ACCEL_Y, 2) X(SOURCE_WHEEL_FRONT_LEFT, 3) \
  X(SOURCE_WHEEL_FRONT_RIGHT, 4) X(SOURCE_WHEEL_REAR_LEFT, 5) X(SOURCE_WHEEL_REAR_RIGHT, 6) \
  X(SOURCE_WHEEL_REAR, 7) X(SOURCE_MOTOR, 8) X(SOURCE_STEERING, 9) X(SOURCE_DIRECTION, 10) \
  X(SOURCE_CAMERA, 11) X(SOURCE_COUNT, 12) X(OK, 0) X(STALE, 1) X(NO_SEGMENT, 2) X(REFUSED, 3) \
  X(ABI, 4) X(NO_POSE, 5) X(TOO_OLD, 6) X(TOO_NEW, 7) X(RESET, 8) X(TIMEOUT, 9) X(BUSY, 10) \
  X(INVALID, 11) X(GAP, 12) X(SYSTEM, 13) X(CLOCK_MONOTONIC, 0) X(CLOCK_REALTIME, 1) \
  X(CLOCK_LOG, 2)
/* Constants of the segment that the Python module lacks. */
#define PINNED_WORDS(X) \
  X(SOURCE_CAPACITY, 16) X(WORD_TICK, 1) X(WORD_TIME, 2) X(WORD_X, 3) X(WORD_Y, 4) \
  X(WORD_YAW, 5) X(WORD_ODOM_X, 6) X(WORD_ODOM_Y, 7) X(WORD_ODOM_YAW, 8) X(WORD_VX, 9) \
  X(WORD_VY, 10) X(WORD_YAW_RATE, 11) X(WORD_VX_DOT, 12) X(WORD_VY_DOT, 13) \
  X(WORD_YAW_ACCEL, 14) X(WORD_ACCEL_X, 15) X(WORD_ACCEL_Y, 16) X(WORD_STEERING, 17) \
  X(WORD_COVARIANCE, 18) X(WORD_MODE, 24) X(WORD_RESETS, 25) X(WORD_JUMP_X, 26) \
  X(WORD_JUMP_Y, 27) X(WORD_JUMP_YAW, 28) X(WORD_DETAILS, 29) \
  X(SEGMENT_MAGIC, 0x314745534D4F444FU) X(ABI_MAJOR, 1) X(ABI_MINOR, 1) X(SEGMENT_LINE_WORDS, 8) \
  X(HEADER_MAGIC, 0) X(HEADER_BYTES, 1) X(HEADER_SLOT_BYTES, 2) X(HEADER_SEGMENT_BYTES, 3) \
  X(HEADER_POSE_WORDS, 4) X(HEADER_DETAILS_WORDS, 5) X(HEADER_INFO_WORDS, 6) \
  X(HEADER_BEAT_WORDS, 7) X(HEADER_INFO, 8) X(HEADER_ABI, 8) X(HEADER_INSTANCE, 9) \
  X(HEADER_PID, 10) X(HEADER_PERIOD, 12) X(HEADER_FIRST_TICK, 13) X(HEADER_REALTIME_OFFSET, 14) \
  X(HEADER_LOG_OFFSET, 15) X(HEADER_SLOTS, 16) X(HEADER_HEAD, 64) X(HEADER_FUTEX, 65) \
  X(HEADER_BEAT, 67) X(HEADER_TICKS, 67) X(HEADER_MISSED, 68) X(HEADER_OVERRUNS, 69) \
  X(HEADER_CARRIED_OVER, 70) X(HEADER_HEARTBEAT, 71) X(HEADER_LAST_OVERRUN, 72) \
  X(HEADER_LAST_OVERRUN_EXECUTION, 73) X(HEADER_MAX_WAKEUP, 74) X(HEADER_MAX_EXECUTION, 75) \
  X(HEADER_WAKEUP, 76) X(HEADER_EXECUTION, 140) X(SEGMENT_HEADER_WORDS, 512) X(POSE_WORDS, 28) \
  X(DETAILS_WORDS, 69) X(INFO_WORDS, 24) X(BEAT_WORDS, 137) X(SLOT_SEQUENCE, 0) X(SLOT_POSE, 1) \
  X(SLOT_DETAILS, 29) X(SLOT_WORDS, 104) X(SEGMENT_SLOTS_MIN, 4) X(SEGMENT_SLOTS_MAX, 1048576) \
  X(STALE_PERIODS, 4)
/* clang-format on */

#endif
