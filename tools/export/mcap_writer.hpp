// Writes MCAP files (https://mcap.dev/spec, version 0): messages in compressed chunks, each with an
// index, followed by a summary, so that readers find any time and topic without reading everything.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace odomd::tools {

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint32_t topics = 0;
};

/// Messages are JSON, and come in the order of their times. For use by one thread.
class McapWriter {
 public:
  /// `out` belongs to this object until finish(). `library` names the program that writes.
  McapWriter(std::ostream& out, std::string_view library);

  /// `schema` is the name of the message's type; Foxglove recognises its own types by name
  /// (https://docs.foxglove.dev/docs/sdk/schemas) and members. The JSON schema follows from the
  /// first message; later messages with this schema must have the same members. Throws
  /// std::invalid_argument for a time before 0.
  void write(const std::string& topic, const std::string& schema, std::int64_t time_ns,
             const nlohmann::ordered_json& message);
  /// Ends the file. Check `out` for write errors.
  McapStatistics finish();

 private:
  using Id = std::uint16_t;
  struct Channel {
    Id id = 0;
    std::uint32_t messages = 0;
  };
  struct ChunkIndex {
    std::uint64_t start_ns = 0;
    std::uint64_t end_ns = 0;
    std::string rest;  ///< of the record: positions and sizes
  };

  void put(std::string_view bytes);
  Channel& channel_for(const std::string& topic, const std::string& schema,
                       const nlohmann::ordered_json& message);
  void end_chunk();
  void write_summary();

  std::ostream& out_;
  std::uint64_t written_ = 0;
  std::uint32_t crc_ = 0;  // of all bytes put since it was set to 0
  std::map<std::string, Id> schemas_;
  std::map<std::string, Channel> channels_;  // key: topic
  std::string schema_records_, channel_records_;
  std::string chunk_;                // records, not yet compressed
  std::map<Id, std::string> index_;  // of the current chunk: times and offsets of its messages
  std::uint64_t chunk_start_ns_ = 0;
  std::uint64_t chunk_end_ns_ = 0;
  std::vector<ChunkIndex> chunks_;
};

}  // namespace odomd::tools
