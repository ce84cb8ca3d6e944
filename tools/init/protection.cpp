#include "tools/init/protection.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "can_protocol/decode/decoder.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

bool is_own(const can::Message& message) {
  const can::Message* own = can::find_message(sim::bus_database(), message.name);
  if (own == nullptr || own->id != message.id || own->format != message.format) return false;
  const can::E2eBinding binding = sim::bus_protection(message);
  return can::find_signal(message, binding.crc_signal) != nullptr &&
         can::find_signal(message, binding.counter_signal) != nullptr;
}

/// Frames of a message that pass, of how many.
struct Checked {
  std::uint64_t passed = 0, frames = 0;
  [[nodiscard]] bool is_protected() const { return 2 * passed > frames; }
};

Checked check(const can::Message& message, const Traffic& traffic) {
  can::SignalBinding binding;
  binding.role = binding.message = message.name;
  binding.signals = {message.signals.back().name};
  const std::array bindings{binding};
  const std::array protections{sim::bus_protection(message)};
  can::Decoder decoder(std::span(&sim::bus_database(), 1), bindings, protections, traffic.buses);
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  Checked checked;
  for (const can::Frame& frame : traffic.frames) {
    const can::DecodeResult result = decoder.decode(frame, samples);
    if (result.message < 0) continue;
    ++checked.frames;
    if (result.verdict == can::FrameVerdict::decoded) ++checked.passed;
  }
  return checked;
}

}  // namespace

std::vector<can::E2eBinding> protections_for(Proposal& proposal,
                                             std::span<const can::Database> databases,
                                             const Traffic& traffic) {
  std::vector<can::E2eBinding> protections;
  for (const can::Database& database : databases)
    for (const can::Message& message : database.messages) {
      std::vector<Choice*> users;
      for (auto& choice : proposal.roles)
        if (choice && choice->candidate.message == &message) users.push_back(&*choice);
      if (users.empty() || !is_own(message)) continue;
      if (traffic.empty() || check(message, traffic).is_protected()) {
        protections.push_back(sim::bus_protection(message));
        continue;
      }
      for (Choice* user : users)
        user->warnings.push_back("the checksums of " + message.name +
                                 " are wrong in the log: it is not protected");
    }
  return protections;
}

bool is_own_bus(const Traffic& traffic) {
  const auto& messages = sim::bus_database().messages;
  const auto came = std::ranges::count_if(messages, [&](const can::Message& message) {
    return std::ranges::any_of(traffic.frames, [&](const can::Frame& frame) {
      return can::frame_key(frame) == can::frame_key(message.id, message.format) &&
             frame.length >= message.length;
    });
  });
  return 2 * static_cast<std::size_t>(came) > messages.size();
}

}  // namespace odomd::tools
