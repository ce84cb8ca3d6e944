/* Prints what the compiler makes of the public headers, one fact a line, for the test that holds
 * the Python module to it: struct NAME SIZE field STRUCT NAME OFFSET SIZE constant NAME VALUE
 */
#include <stdio.h>

#include <odom/odom.h>

/* clang-format off */
#define POSE(X) \
  X(tick) X(time_ns) X(x) X(y) X(yaw) X(odom_x) X(odom_y) X(odom_yaw) X(vx) X(vy) X(yaw_rate) \
  X(vx_dot) X(vy_dot) X(yaw_accel) X(accel_x) X(accel_y) X(steering) X(covariance) X(mode) \
  X(conditions) X(reset_count) X(health) X(jump_x) X(jump_y) X(jump_yaw)
#define DETAILS(X) \
  X(velocity_covariance) X(gyro_bias) X(gyro_scale) X(accel_bias_x) X(accel_bias_y) X(wheel_scale) \
  X(steering_offset) X(stiffness_scale) X(calibration_sigma) X(calibration_valid) X(correction_x) \
  X(correction_y) X(correction_yaw) X(dead_reckoning_since_ns) X(source_age_ns) X(frames) \
  X(camera_messages) X(wakeup_latency_ns) X(execution_ns) X(gyro_latency) X(wheel_latency) \
  X(steering_latency) X(grip) X(further_calibration_sigma)
#define INFO(X) \
  X(abi_major) X(abi_minor) X(instance_id) X(writer_pid) X(writer_start_ns) X(period_ns) \
  X(first_tick_ns) X(realtime_offset_ns) X(log_offset_ns) X(slots) X(mass) X(front_axle) \
  X(rear_axle) X(yaw_inertia) X(cornering_stiffness_front) X(cornering_stiffness_rear) \
  X(track_width) X(model) X(version)
#define BEAT(X) \
  X(ticks) X(missed) X(overruns) X(carried_over) X(heartbeat_ns) X(last_overrun_ns) \
  X(last_overrun_execution_ns) X(max_wakeup_ns) X(max_execution_ns) X(wakeup) X(execution)
#define CAMERA_MESSAGE(X) \
  X(magic) X(version) X(clock) X(sequence) X(capture_ns) X(x) X(y) X(yaw) X(sigma_x) X(sigma_y) \
  X(sigma_yaw) X(reserved)
#define CONSTANTS(X) \
  X(OK) X(STALE) X(NO_SEGMENT) X(REFUSED) X(ABI) X(NO_POSE) X(TOO_OLD) X(TOO_NEW) X(RESET) \
  X(TIMEOUT) X(BUSY) X(INVALID) X(GAP) X(SYSTEM) X(INITIALISING) X(TRACKING) X(DEAD_RECKONING) \
  X(DEGRADED) X(STANDSTILL) X(FAULT) X(COND_NOT_REALTIME) X(COND_RESTARTED) X(COND_BUS_DOWN) \
  X(COND_SIGNAL_TIMEOUT) X(COND_PROTECTION) X(COND_FRAMES_LOST) X(COND_CARRIED_OVER) \
  X(COND_CLOCK_STEPPED) X(COND_SUSPENDED) X(COND_CAMERA_REJECTED) X(COND_MODEL_FAULT) \
  X(COND_NON_FINITE) X(COND_INPUT_ENDED) X(COND_SENSOR_FAULT) X(COND_WHEEL_SLIP) X(COND_MISWIRED) \
  X(COND_INCONSISTENT) X(COND_BIAS_UNLEARNT) X(COND_SCALE_IMPLAUSIBLE) X(COND_CAMERA_REFUSED) \
  X(SOURCE_YAW_RATE) X(SOURCE_ACCEL_X) X(SOURCE_ACCEL_Y) X(SOURCE_WHEEL_FRONT_LEFT) \
  X(SOURCE_WHEEL_FRONT_RIGHT) X(SOURCE_WHEEL_REAR_LEFT) X(SOURCE_WHEEL_REAR_RIGHT) \
  X(SOURCE_WHEEL_REAR) X(SOURCE_MOTOR) X(SOURCE_STEERING) X(SOURCE_DIRECTION) X(SOURCE_CAMERA) \
  X(SOURCE_COUNT) X(CLOCK_MONOTONIC) X(CLOCK_REALTIME) X(CLOCK_LOG)
/* clang-format on */

#define FIELD(name) \
  printf("field %s %s %zu %zu\n", type, #name, offsetof(Struct, name), sizeof(((Struct*)0)->name));
#define STRUCT(name, FIELDS)                         \
  {                                                  \
    typedef name Struct;                             \
    const char* const type = #name;                  \
    printf("struct %s %zu\n", type, sizeof(Struct)); \
    FIELDS(FIELD)                                    \
  }
#define CONSTANT(name) printf("constant ODOM_%s %lld\n", #name, (long long)(ODOM_##name));

int main(void) {
  STRUCT(odom_pose, POSE)
  STRUCT(odom_details, DETAILS)
  STRUCT(odom_info, INFO)
  STRUCT(odom_beat, BEAT)
  STRUCT(odom_camera_message, CAMERA_MESSAGE)
  CONSTANTS(CONSTANT)
  return 0;
}
