// The layout is a contract with programs that were built years ago: every size, offset and number
// that they were compiled with is pinned here. A failure here breaks them: append instead, and
// raise the ABI minor.
#include <gtest/gtest.h>
#include <cstddef>

#include "shm_api/layout/segment.h"

namespace {

// Every field of every struct that leaves the program.
TEST(Abi, StructsArePinned) {
  EXPECT_EQ(sizeof(odom_pose), 224U);
  EXPECT_EQ(offsetof(odom_pose, tick), 0U);
  EXPECT_EQ(offsetof(odom_pose, time_ns), 8U);
  EXPECT_EQ(offsetof(odom_pose, x), 16U);
  EXPECT_EQ(offsetof(odom_pose, y), 24U);
  EXPECT_EQ(offsetof(odom_pose, yaw), 32U);
  EXPECT_EQ(offsetof(odom_pose, odom_x), 40U);
  EXPECT_EQ(offsetof(odom_pose, odom_y), 48U);
  EXPECT_EQ(offsetof(odom_pose, odom_yaw), 56U);
  EXPECT_EQ(offsetof(odom_pose, vx), 64U);
  EXPECT_EQ(offsetof(odom_pose, vy), 72U);
  EXPECT_EQ(offsetof(odom_pose, yaw_rate), 80U);
  EXPECT_EQ(offsetof(odom_pose, vx_dot), 88U);
  EXPECT_EQ(offsetof(odom_pose, vy_dot), 96U);
  EXPECT_EQ(offsetof(odom_pose, yaw_accel), 104U);
  EXPECT_EQ(offsetof(odom_pose, accel_x), 112U);
  EXPECT_EQ(offsetof(odom_pose, accel_y), 120U);
  EXPECT_EQ(offsetof(odom_pose, steering), 128U);
  EXPECT_EQ(offsetof(odom_pose, covariance), 136U);
  EXPECT_EQ(offsetof(odom_pose, mode), 184U);
  EXPECT_EQ(offsetof(odom_pose, conditions), 188U);
  EXPECT_EQ(offsetof(odom_pose, reset_count), 192U);
  EXPECT_EQ(offsetof(odom_pose, health), 196U);
  EXPECT_EQ(offsetof(odom_pose, jump_x), 200U);
  EXPECT_EQ(offsetof(odom_pose, jump_y), 208U);
  EXPECT_EQ(offsetof(odom_pose, jump_yaw), 216U);

  EXPECT_EQ(sizeof(odom_details), 552U);
  EXPECT_EQ(offsetof(odom_details, velocity_covariance), 0U);
  EXPECT_EQ(offsetof(odom_details, gyro_bias), 120U);
  EXPECT_EQ(offsetof(odom_details, gyro_scale), 128U);
  EXPECT_EQ(offsetof(odom_details, accel_bias_x), 136U);
  EXPECT_EQ(offsetof(odom_details, accel_bias_y), 144U);
  EXPECT_EQ(offsetof(odom_details, wheel_scale), 152U);
  EXPECT_EQ(offsetof(odom_details, steering_offset), 160U);
  EXPECT_EQ(offsetof(odom_details, stiffness_scale), 168U);
  EXPECT_EQ(offsetof(odom_details, calibration_sigma), 176U);
  EXPECT_EQ(offsetof(odom_details, calibration_valid), 232U);
  EXPECT_EQ(offsetof(odom_details, correction_x), 240U);
  EXPECT_EQ(offsetof(odom_details, correction_y), 248U);
  EXPECT_EQ(offsetof(odom_details, correction_yaw), 256U);
  EXPECT_EQ(offsetof(odom_details, dead_reckoning_since_ns), 264U);
  EXPECT_EQ(offsetof(odom_details, source_age_ns), 272U);
  EXPECT_EQ(offsetof(odom_details, frames), 400U);
  EXPECT_EQ(offsetof(odom_details, camera_messages), 464U);
  EXPECT_EQ(offsetof(odom_details, wakeup_latency_ns), 472U);
  EXPECT_EQ(offsetof(odom_details, execution_ns), 480U);
  EXPECT_EQ(offsetof(odom_details, gyro_latency), 488U);
  EXPECT_EQ(offsetof(odom_details, wheel_latency), 496U);
  EXPECT_EQ(offsetof(odom_details, steering_latency), 504U);
  EXPECT_EQ(offsetof(odom_details, grip), 512U);
  EXPECT_EQ(offsetof(odom_details, further_calibration_sigma), 520U);

  EXPECT_EQ(sizeof(odom_info), 192U);
  EXPECT_EQ(offsetof(odom_info, abi_major), 0U);
  EXPECT_EQ(offsetof(odom_info, abi_minor), 4U);
  EXPECT_EQ(offsetof(odom_info, instance_id), 8U);
  EXPECT_EQ(offsetof(odom_info, writer_pid), 16U);
  EXPECT_EQ(offsetof(odom_info, writer_start_ns), 24U);
  EXPECT_EQ(offsetof(odom_info, period_ns), 32U);
  EXPECT_EQ(offsetof(odom_info, first_tick_ns), 40U);
  EXPECT_EQ(offsetof(odom_info, realtime_offset_ns), 48U);
  EXPECT_EQ(offsetof(odom_info, log_offset_ns), 56U);
  EXPECT_EQ(offsetof(odom_info, slots), 64U);
  EXPECT_EQ(offsetof(odom_info, mass), 72U);
  EXPECT_EQ(offsetof(odom_info, front_axle), 80U);
  EXPECT_EQ(offsetof(odom_info, rear_axle), 88U);
  EXPECT_EQ(offsetof(odom_info, yaw_inertia), 96U);
  EXPECT_EQ(offsetof(odom_info, cornering_stiffness_front), 104U);
  EXPECT_EQ(offsetof(odom_info, cornering_stiffness_rear), 112U);
  EXPECT_EQ(offsetof(odom_info, track_width), 120U);
  EXPECT_EQ(offsetof(odom_info, model), 128U);
  EXPECT_EQ(offsetof(odom_info, version), 160U);

  EXPECT_EQ(sizeof(odom_beat), 1096U);
  EXPECT_EQ(offsetof(odom_beat, ticks), 0U);
  EXPECT_EQ(offsetof(odom_beat, missed), 8U);
  EXPECT_EQ(offsetof(odom_beat, overruns), 16U);
  EXPECT_EQ(offsetof(odom_beat, carried_over), 24U);
  EXPECT_EQ(offsetof(odom_beat, heartbeat_ns), 32U);
  EXPECT_EQ(offsetof(odom_beat, last_overrun_ns), 40U);
  EXPECT_EQ(offsetof(odom_beat, last_overrun_execution_ns), 48U);
  EXPECT_EQ(offsetof(odom_beat, max_wakeup_ns), 56U);
  EXPECT_EQ(offsetof(odom_beat, max_execution_ns), 64U);
  EXPECT_EQ(offsetof(odom_beat, wakeup), 72U);
  EXPECT_EQ(offsetof(odom_beat, execution), 584U);

  EXPECT_EQ(sizeof(odom_camera_message), 80U);
  EXPECT_EQ(offsetof(odom_camera_message, magic), 0U);
  EXPECT_EQ(offsetof(odom_camera_message, version), 4U);
  EXPECT_EQ(offsetof(odom_camera_message, clock), 6U);
  EXPECT_EQ(offsetof(odom_camera_message, sequence), 8U);
  EXPECT_EQ(offsetof(odom_camera_message, capture_ns), 16U);
  EXPECT_EQ(offsetof(odom_camera_message, x), 24U);
  EXPECT_EQ(offsetof(odom_camera_message, y), 32U);
  EXPECT_EQ(offsetof(odom_camera_message, yaw), 40U);
  EXPECT_EQ(offsetof(odom_camera_message, sigma_x), 48U);
  EXPECT_EQ(offsetof(odom_camera_message, sigma_y), 56U);
  EXPECT_EQ(offsetof(odom_camera_message, sigma_yaw), 64U);
  EXPECT_EQ(offsetof(odom_camera_message, reserved), 72U);
}

// A value may be added at the end of an enum (ODOM_SOURCE_COUNT rises); none changes.
TEST(Abi, NumbersOfEnumsArePinned) {
  EXPECT_EQ(ODOM_INITIALISING, 0);
  EXPECT_EQ(ODOM_TRACKING, 1);
  EXPECT_EQ(ODOM_DEAD_RECKONING, 2);
  EXPECT_EQ(ODOM_DEGRADED, 3);
  EXPECT_EQ(ODOM_STANDSTILL, 4);
  EXPECT_EQ(ODOM_FAULT, 5);
  EXPECT_EQ(ODOM_COND_NOT_REALTIME, 1);
  EXPECT_EQ(ODOM_COND_RESTARTED, 2);
  EXPECT_EQ(ODOM_COND_BUS_DOWN, 4);
  EXPECT_EQ(ODOM_COND_SIGNAL_TIMEOUT, 8);
  EXPECT_EQ(ODOM_COND_PROTECTION, 16);
  EXPECT_EQ(ODOM_COND_FRAMES_LOST, 32);
  EXPECT_EQ(ODOM_COND_CARRIED_OVER, 64);
  EXPECT_EQ(ODOM_COND_CLOCK_STEPPED, 128);
  EXPECT_EQ(ODOM_COND_SUSPENDED, 256);
  EXPECT_EQ(ODOM_COND_CAMERA_REJECTED, 512);
  EXPECT_EQ(ODOM_COND_MODEL_FAULT, 1024);
  EXPECT_EQ(ODOM_COND_NON_FINITE, 2048);
  EXPECT_EQ(ODOM_COND_INPUT_ENDED, 4096);
  EXPECT_EQ(ODOM_COND_SENSOR_FAULT, 8192);
  EXPECT_EQ(ODOM_COND_WHEEL_SLIP, 16384);
  EXPECT_EQ(ODOM_COND_MISWIRED, 32768);
  EXPECT_EQ(ODOM_COND_INCONSISTENT, 65536);
  EXPECT_EQ(ODOM_COND_BIAS_UNLEARNT, 131072);
  EXPECT_EQ(ODOM_COND_SCALE_IMPLAUSIBLE, 262144);
  EXPECT_EQ(ODOM_COND_CAMERA_REFUSED, 524288);
  EXPECT_EQ(ODOM_SOURCE_YAW_RATE, 0);
  EXPECT_EQ(ODOM_SOURCE_ACCEL_X, 1);
  EXPECT_EQ(ODOM_SOURCE_ACCEL_Y, 2);
  EXPECT_EQ(ODOM_SOURCE_WHEEL_FRONT_LEFT, 3);
  EXPECT_EQ(ODOM_SOURCE_WHEEL_FRONT_RIGHT, 4);
  EXPECT_EQ(ODOM_SOURCE_WHEEL_REAR_LEFT, 5);
  EXPECT_EQ(ODOM_SOURCE_WHEEL_REAR_RIGHT, 6);
  EXPECT_EQ(ODOM_SOURCE_WHEEL_REAR, 7);
  EXPECT_EQ(ODOM_SOURCE_MOTOR, 8);
  EXPECT_EQ(ODOM_SOURCE_STEERING, 9);
  EXPECT_EQ(ODOM_SOURCE_DIRECTION, 10);
  EXPECT_EQ(ODOM_SOURCE_CAMERA, 11);
  EXPECT_EQ(ODOM_SOURCE_COUNT, 12);
  EXPECT_EQ(ODOM_SOURCE_CAPACITY, 16);
  EXPECT_EQ(ODOM_OK, 0);
  EXPECT_EQ(ODOM_STALE, 1);
  EXPECT_EQ(ODOM_NO_SEGMENT, 2);
  EXPECT_EQ(ODOM_REFUSED, 3);
  EXPECT_EQ(ODOM_ABI, 4);
  EXPECT_EQ(ODOM_NO_POSE, 5);
  EXPECT_EQ(ODOM_TOO_OLD, 6);
  EXPECT_EQ(ODOM_TOO_NEW, 7);
  EXPECT_EQ(ODOM_RESET, 8);
  EXPECT_EQ(ODOM_TIMEOUT, 9);
  EXPECT_EQ(ODOM_BUSY, 10);
  EXPECT_EQ(ODOM_INVALID, 11);
  EXPECT_EQ(ODOM_GAP, 12);
  EXPECT_EQ(ODOM_SYSTEM, 13);
  EXPECT_EQ(ODOM_WORD_TICK, 1);
  EXPECT_EQ(ODOM_WORD_TIME, 2);
  EXPECT_EQ(ODOM_WORD_X, 3);
  EXPECT_EQ(ODOM_WORD_Y, 4);
  EXPECT_EQ(ODOM_WORD_YAW, 5);
  EXPECT_EQ(ODOM_WORD_ODOM_X, 6);
  EXPECT_EQ(ODOM_WORD_ODOM_Y, 7);
  EXPECT_EQ(ODOM_WORD_ODOM_YAW, 8);
  EXPECT_EQ(ODOM_WORD_VX, 9);
  EXPECT_EQ(ODOM_WORD_VY, 10);
  EXPECT_EQ(ODOM_WORD_YAW_RATE, 11);
  EXPECT_EQ(ODOM_WORD_VX_DOT, 12);
  EXPECT_EQ(ODOM_WORD_VY_DOT, 13);
  EXPECT_EQ(ODOM_WORD_YAW_ACCEL, 14);
  EXPECT_EQ(ODOM_WORD_ACCEL_X, 15);
  EXPECT_EQ(ODOM_WORD_ACCEL_Y, 16);
  EXPECT_EQ(ODOM_WORD_STEERING, 17);
  EXPECT_EQ(ODOM_WORD_COVARIANCE, 18);
  EXPECT_EQ(ODOM_WORD_MODE, 24);
  EXPECT_EQ(ODOM_WORD_RESETS, 25);
  EXPECT_EQ(ODOM_WORD_JUMP_X, 26);
  EXPECT_EQ(ODOM_WORD_JUMP_Y, 27);
  EXPECT_EQ(ODOM_WORD_JUMP_YAW, 28);
  EXPECT_EQ(ODOM_WORD_DETAILS, 29);
  EXPECT_EQ(ODOM_CLOCK_MONOTONIC, 0);
  EXPECT_EQ(ODOM_CLOCK_REALTIME, 1);
  EXPECT_EQ(ODOM_CLOCK_LOG, 2);
}

TEST(Abi, WordsOfTheSegmentArePinned) {
  EXPECT_EQ(ODOM_SEGMENT_MAGIC, 0x314745534D4F444FU);
  EXPECT_EQ(ODOM_ABI_MAJOR, 1);
  EXPECT_EQ(ODOM_ABI_MINOR, 1);
  EXPECT_EQ(ODOM_SEGMENT_LINE_WORDS, 8);
  EXPECT_EQ(ODOM_HEADER_MAGIC, 0);
  EXPECT_EQ(ODOM_HEADER_BYTES, 1);
  EXPECT_EQ(ODOM_HEADER_SLOT_BYTES, 2);
  EXPECT_EQ(ODOM_HEADER_SEGMENT_BYTES, 3);
  EXPECT_EQ(ODOM_HEADER_POSE_WORDS, 4);
  EXPECT_EQ(ODOM_HEADER_DETAILS_WORDS, 5);
  EXPECT_EQ(ODOM_HEADER_INFO_WORDS, 6);
  EXPECT_EQ(ODOM_HEADER_BEAT_WORDS, 7);
  EXPECT_EQ(ODOM_HEADER_INFO, 8);
  EXPECT_EQ(ODOM_HEADER_ABI, 8);
  EXPECT_EQ(ODOM_HEADER_INSTANCE, 9);
  EXPECT_EQ(ODOM_HEADER_PID, 10);
  EXPECT_EQ(ODOM_HEADER_PERIOD, 12);
  EXPECT_EQ(ODOM_HEADER_FIRST_TICK, 13);
  EXPECT_EQ(ODOM_HEADER_REALTIME_OFFSET, 14);
  EXPECT_EQ(ODOM_HEADER_LOG_OFFSET, 15);
  EXPECT_EQ(ODOM_HEADER_SLOTS, 16);
  EXPECT_EQ(ODOM_HEADER_HEAD, 64);
  EXPECT_EQ(ODOM_HEADER_FUTEX, 65);
  EXPECT_EQ(ODOM_HEADER_BEAT, 67);
  EXPECT_EQ(ODOM_HEADER_TICKS, 67);
  EXPECT_EQ(ODOM_HEADER_MISSED, 68);
  EXPECT_EQ(ODOM_HEADER_OVERRUNS, 69);
  EXPECT_EQ(ODOM_HEADER_CARRIED_OVER, 70);
  EXPECT_EQ(ODOM_HEADER_HEARTBEAT, 71);
  EXPECT_EQ(ODOM_HEADER_LAST_OVERRUN, 72);
  EXPECT_EQ(ODOM_HEADER_LAST_OVERRUN_EXECUTION, 73);
  EXPECT_EQ(ODOM_HEADER_MAX_WAKEUP, 74);
  EXPECT_EQ(ODOM_HEADER_MAX_EXECUTION, 75);
  EXPECT_EQ(ODOM_HEADER_WAKEUP, 76);
  EXPECT_EQ(ODOM_HEADER_EXECUTION, 140);
  EXPECT_EQ(ODOM_SEGMENT_HEADER_WORDS, 512);
  EXPECT_EQ(ODOM_POSE_WORDS, 28);
  EXPECT_EQ(ODOM_DETAILS_WORDS, 69);
  EXPECT_EQ(ODOM_INFO_WORDS, 24);
  EXPECT_EQ(ODOM_BEAT_WORDS, 137);
  EXPECT_EQ(ODOM_SLOT_SEQUENCE, 0);
  EXPECT_EQ(ODOM_SLOT_POSE, 1);
  EXPECT_EQ(ODOM_SLOT_DETAILS, 29);
  EXPECT_EQ(ODOM_SLOT_WORDS, 104);
  EXPECT_EQ(ODOM_SEGMENT_SLOTS_MIN, 4);
  EXPECT_EQ(ODOM_SEGMENT_SLOTS_MAX, 1048576);
  EXPECT_EQ(ODOM_STALE_PERIODS, 4);
}

}  // namespace
