// The status of a daemon without any fault.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace odomd::tools::doctor {

inline nlohmann::json sound_source(const std::string& name, int dimension) {
  return {{"name", name},
          {"configured", true},
          {"healthy", true},
          {"flag", "ok"},
          {"wiring", "ok"},
          {"inconsistent", false},
          {"age_s", 0.004},
          {"timeout_s", 0.03},
          {"verdicts", {{"fused", 1'000}, {"gated", 0}, {"too_old", 0}, {"future", 0}}},
          {"innovations",
           {{"count", 1'000}, {"gated", 3}, {"dimension", dimension}, {"mean_nis", dimension}}}};
}

inline nlohmann::json sound_message(const std::string& name) {
  return {{"name", name},
          {"id", 288},
          {"age_s", 0.004},
          {"verdicts", {{"decoded", 1'000}, {"too_short", 0}}}};
}

inline nlohmann::json sound_status() {
  return {{"version", ODOMD_VERSION},
          {"uptime_s", 100.0},
          {"shm", "/odomd"},
          {"mode", "tracking"},
          {"conditions", nlohmann::json::array()},
          {"beat",
           {{"period_s", 0.005},
            {"ticks", 20'000},
            {"missed", 1},
            {"overruns", 0},
            {"wakeup_us", {{"max", 4'000.0}}},
            {"execution_us", {{"p999", 80.0}}}}},
          {"can",
           {{{"name", "can0"},
             {"link", "up"},
             {"received", 50'000},
             {"lost", 0},
             {"controller_overflows", 0}}}},
          {"messages", {sound_message("IMU"), sound_message("WHEELS")}},
          {"sources",
           {sound_source("yaw_rate", 1), sound_source("wheel_front_left", 1),
            sound_source("wheel_rear", 1), sound_source("camera", 3)}},
          {"camera", {{"socket", "/run/odomd/camera.sock"}, {"messages", 900}, {"malformed", 0}}},
          {"realtime",
           {{"priority", 45},
            {"memory_locked", true},
            {"dma_latency_held", true},
            {"refusals", nlohmann::json::array()}}}};
}

}  // namespace odomd::tools::doctor
