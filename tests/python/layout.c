/* Prints what the compiler makes of the public headers, one fact a line, for the test that holds
 * the Python module to it: struct NAME SIZE field STRUCT NAME OFFSET SIZE constant NAME VALUE
 */
#include <stdio.h>

#include <odom/odom.h>

#define STRUCT(type) printf("struct %s %zu\n", #type, sizeof(type))
#define FIELD(type, name) \
  printf("field %s %s %zu %zu\n", #type, #name, offsetof(type, name), sizeof(((type*)0)->name))
#define CONSTANT(name) printf("constant %s %lld\n", #name, (long long)(name))

static void pose(void) {
  STRUCT(odom_pose);
  FIELD(odom_pose, tick);
  FIELD(odom_pose, time_ns);
  FIELD(odom_pose, x);
  FIELD(odom_pose, y);
  FIELD(odom_pose, yaw);
  FIELD(odom_pose, odom_x);
  FIELD(odom_pose, odom_y);
  FIELD(odom_pose, odom_yaw);
  FIELD(odom_pose, vx);
  FIELD(odom_pose, vy);
  FIELD(odom_pose, yaw_rate);
  FIELD(odom_pose, vx_dot);
  FIELD(odom_pose, vy_dot);
  FIELD(odom_pose, yaw_accel);
  FIELD(odom_pose, accel_x);
  FIELD(odom_pose, accel_y);
  FIELD(odom_pose, steering);
  FIELD(odom_pose, covariance);
  FIELD(odom_pose, mode);
  FIELD(odom_pose, conditions);
  FIELD(odom_pose, reset_count);
  FIELD(odom_pose, health);
  FIELD(odom_pose, jump_x);
  FIELD(odom_pose, jump_y);
  FIELD(odom_pose, jump_yaw);
}

static void details(void) {
  STRUCT(odom_details);
  FIELD(odom_details, velocity_covariance);
  FIELD(odom_details, gyro_bias);
  FIELD(odom_details, gyro_scale);
  FIELD(odom_details, accel_bias_x);
  FIELD(odom_details, accel_bias_y);
  FIELD(odom_details, wheel_scale);
  FIELD(odom_details, steering_offset);
  FIELD(odom_details, stiffness_scale);
  FIELD(odom_details, calibration_sigma);
  FIELD(odom_details, calibration_valid);
  FIELD(odom_details, correction_x);
  FIELD(odom_details, correction_y);
  FIELD(odom_details, correction_yaw);
  FIELD(odom_details, dead_reckoning_since_ns);
  FIELD(odom_details, source_age_ns);
  FIELD(odom_details, frames);
  FIELD(odom_details, camera_messages);
  FIELD(odom_details, wakeup_latency_ns);
  FIELD(odom_details, execution_ns);
  FIELD(odom_details, gyro_latency);
  FIELD(odom_details, wheel_latency);
  FIELD(odom_details, steering_latency);
  FIELD(odom_details, grip);
  FIELD(odom_details, further_calibration_sigma);
}

static void info(void) {
  STRUCT(odom_info);
  FIELD(odom_info, abi_major);
  FIELD(odom_info, abi_minor);
  FIELD(odom_info, instance_id);
  FIELD(odom_info, writer_pid);
  FIELD(odom_info, writer_start_ns);
  FIELD(odom_info, period_ns);
  FIELD(odom_info, first_tick_ns);
  FIELD(odom_info, realtime_offset_ns);
  FIELD(odom_info, log_offset_ns);
  FIELD(odom_info, slots);
  FIELD(odom_info, mass);
  FIELD(odom_info, front_axle);
  FIELD(odom_info, rear_axle);
  FIELD(odom_info, yaw_inertia);
  FIELD(odom_info, cornering_stiffness_front);
  FIELD(odom_info, cornering_stiffness_rear);
  FIELD(odom_info, track_width);
  FIELD(odom_info, model);
  FIELD(odom_info, version);
}

static void beat(void) {
  STRUCT(odom_beat);
  FIELD(odom_beat, ticks);
  FIELD(odom_beat, missed);
  FIELD(odom_beat, overruns);
  FIELD(odom_beat, carried_over);
  FIELD(odom_beat, heartbeat_ns);
  FIELD(odom_beat, last_overrun_ns);
  FIELD(odom_beat, last_overrun_execution_ns);
  FIELD(odom_beat, max_wakeup_ns);
  FIELD(odom_beat, max_execution_ns);
  FIELD(odom_beat, wakeup);
  FIELD(odom_beat, execution);
}

static void camera_message(void) {
  STRUCT(odom_camera_message);
  FIELD(odom_camera_message, magic);
  FIELD(odom_camera_message, version);
  FIELD(odom_camera_message, clock);
  FIELD(odom_camera_message, sequence);
  FIELD(odom_camera_message, capture_ns);
  FIELD(odom_camera_message, x);
  FIELD(odom_camera_message, y);
  FIELD(odom_camera_message, yaw);
  FIELD(odom_camera_message, sigma_x);
  FIELD(odom_camera_message, sigma_y);
  FIELD(odom_camera_message, sigma_yaw);
  FIELD(odom_camera_message, reserved);
}

static void constants(void) {
  CONSTANT(ODOM_OK);
  CONSTANT(ODOM_STALE);
  CONSTANT(ODOM_NO_SEGMENT);
  CONSTANT(ODOM_REFUSED);
  CONSTANT(ODOM_ABI);
  CONSTANT(ODOM_NO_POSE);
  CONSTANT(ODOM_TOO_OLD);
  CONSTANT(ODOM_TOO_NEW);
  CONSTANT(ODOM_RESET);
  CONSTANT(ODOM_TIMEOUT);
  CONSTANT(ODOM_BUSY);
  CONSTANT(ODOM_INVALID);
  CONSTANT(ODOM_GAP);
  CONSTANT(ODOM_SYSTEM);

  CONSTANT(ODOM_INITIALISING);
  CONSTANT(ODOM_TRACKING);
  CONSTANT(ODOM_DEAD_RECKONING);
  CONSTANT(ODOM_DEGRADED);
  CONSTANT(ODOM_STANDSTILL);
  CONSTANT(ODOM_FAULT);

  CONSTANT(ODOM_COND_NOT_REALTIME);
  CONSTANT(ODOM_COND_RESTARTED);
  CONSTANT(ODOM_COND_BUS_DOWN);
  CONSTANT(ODOM_COND_SIGNAL_TIMEOUT);
  CONSTANT(ODOM_COND_PROTECTION);
  CONSTANT(ODOM_COND_FRAMES_LOST);
  CONSTANT(ODOM_COND_CARRIED_OVER);
  CONSTANT(ODOM_COND_CLOCK_STEPPED);
  CONSTANT(ODOM_COND_SUSPENDED);
  CONSTANT(ODOM_COND_CAMERA_REJECTED);
  CONSTANT(ODOM_COND_MODEL_FAULT);
  CONSTANT(ODOM_COND_NON_FINITE);
  CONSTANT(ODOM_COND_INPUT_ENDED);
  CONSTANT(ODOM_COND_SENSOR_FAULT);
  CONSTANT(ODOM_COND_WHEEL_SLIP);
  CONSTANT(ODOM_COND_MISWIRED);
  CONSTANT(ODOM_COND_INCONSISTENT);
  CONSTANT(ODOM_COND_BIAS_UNLEARNT);
  CONSTANT(ODOM_COND_SCALE_IMPLAUSIBLE);
  CONSTANT(ODOM_COND_CAMERA_REFUSED);

  CONSTANT(ODOM_SOURCE_YAW_RATE);
  CONSTANT(ODOM_SOURCE_ACCEL_X);
  CONSTANT(ODOM_SOURCE_ACCEL_Y);
  CONSTANT(ODOM_SOURCE_WHEEL_FRONT_LEFT);
  CONSTANT(ODOM_SOURCE_WHEEL_FRONT_RIGHT);
  CONSTANT(ODOM_SOURCE_WHEEL_REAR_LEFT);
  CONSTANT(ODOM_SOURCE_WHEEL_REAR_RIGHT);
  CONSTANT(ODOM_SOURCE_WHEEL_REAR);
  CONSTANT(ODOM_SOURCE_MOTOR);
  CONSTANT(ODOM_SOURCE_STEERING);
  CONSTANT(ODOM_SOURCE_DIRECTION);
  CONSTANT(ODOM_SOURCE_CAMERA);
  CONSTANT(ODOM_SOURCE_COUNT);

  CONSTANT(ODOM_CLOCK_MONOTONIC);
  CONSTANT(ODOM_CLOCK_REALTIME);
  CONSTANT(ODOM_CLOCK_LOG);
}

int main(void) {
  pose();
  details();
  info();
  beat();
  camera_message();
  constants();
  return 0;
}
