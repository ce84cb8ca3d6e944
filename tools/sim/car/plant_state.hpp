// The layout of the plant's state; for its own files only.
#pragma once

#include <cstddef>

#include "tools/sim/car/chassis.hpp"

namespace odomd::sim {

// Indices in the state.
enum : std::size_t {
  pos_x,
  pos_y,
  heading,
  vel_x,
  vel_y,
  rate,
  steer,
  drive,
  shift_x,
  shift_y,
  roll,
  roll_rate,
  pitch,
  pitch_rate,
  wheels_begin
};
enum : std::size_t { spin, turned, bend_x, bend_y };

constexpr std::size_t at(std::size_t wheel, std::size_t what) {
  return wheels_begin + 4 * wheel + what;
}

template <class State>
Attitude attitude(const State& s) {
  return {
      .roll = s[roll], .roll_rate = s[roll_rate], .pitch = s[pitch], .pitch_rate = s[pitch_rate]};
}

}  // namespace odomd::sim
