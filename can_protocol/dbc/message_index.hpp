// Finds the message that describes a frame: as the decoder does, but among all messages.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <unordered_map>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/frame.hpp"

namespace odomd::can {

/// Messages by identifier; if several databases have the same, the first one applies. The databases
/// must outlive the index.
class MessageIndex {
 public:
  explicit MessageIndex(std::span<const Database> databases) {
    for (const Database& database : databases)
      for (const Message& message : database.messages)
        by_mask_[message.id_mask].try_emplace(
            frame_key(message.id & message.id_mask, message.format), &message);
  }

  /// Null if there is none.
  [[nodiscard]] const Message* find(const Frame& frame) const {
    for (const auto& [mask, messages] : by_mask_)
      if (const auto found = messages.find(frame_key(frame.id & mask, frame.format));
          found != messages.end())
        return found->second;
    return nullptr;
  }

 private:
  /// Larger masks first: whole identifiers before groups.
  std::map<std::uint32_t, std::unordered_map<std::uint32_t, const Message*>, std::greater<>>
      by_mask_;
};

}  // namespace odomd::can
