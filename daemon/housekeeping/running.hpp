// References to all running parts, for housekeeping and the status.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/sources/frame_source.hpp"
#include "can_protocol/sources/log_clock.hpp"
#include "daemon/core/config.hpp"
#include "daemon/housekeeping/controllers.hpp"
#include "daemon/journal/event.hpp"
#include "daemon/realtime/beat.hpp"
#include "daemon/realtime/privileges.hpp"
#include "daemon/sockets/camera_server.hpp"
#include "shm_api/writer.hpp"

namespace odomd::daemon {

class Pipeline;
class RecordingTap;

struct Running {
  const Config& config;
  const can::BusNames& buses;
  const MachineGrant& machine;
  const ThreadGrant& beat_thread;
  const std::vector<std::unique_ptr<can::FrameSource>>& sources;
  const can::LogClock& log_clock;
  const Pipeline& pipeline;
  shm::Writer& writer;
  CameraServer& cameras;
  EventRing& events;
  Beat& beat;
  ControllerWatch& controllers;
  RecordingTap& tap;
  std::int64_t started_ns = 0;  ///< CLOCK_MONOTONIC
};

/// Whether all inputs have ended; files and pipes end, interfaces never do.
[[nodiscard]] inline bool inputs_ended(const Running& running) {
  return std::ranges::all_of(
      running.sources, [](const auto& source) { return source->link() == can::LinkState::ended; });
}

}  // namespace odomd::daemon
