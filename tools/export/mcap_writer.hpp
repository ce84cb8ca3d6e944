// Writes MCAP files (https://mcap.dev/spec, version 0): messages in compressed chunks, each with an
// index, followed by a summary, so that readers find any time and topic without reading everything.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::tools {

enum class McapCompression : std::uint8_t { none, zstd };

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint32_t topics = 0;
};

/// Schemas and messages are JSON. Messages must come in the order of their times; a schema or
/// channel without a message is left out of the file. For use by one thread.
class McapWriter {
 public:
  using Id = std::uint16_t;

  /// `out` belongs to this object until finish(). `library` names the program that writes.
  McapWriter(std::ostream& out, McapCompression compression, std::string_view library);

  /// `text` is a JSON schema.
  [[nodiscard]] Id add_schema(std::string_view name, std::string_view text);
  [[nodiscard]] Id add_channel(std::string_view topic, Id schema);
  /// A message on the channel. `time_ns` is not negative.
  void write(Id id, std::int64_t time_ns, std::string_view json);
  /// Ends the file. Check `out` for write errors.
  McapStatistics finish();

 private:
  struct Schema {
    std::string record;
    bool written = false;
  };
  struct Channel {
    std::string record;
    Id schema = 0;
    bool written = false;
    std::uint32_t messages = 0;
  };
  struct ChunkIndex {
    std::uint64_t start_ns = 0;
    std::uint64_t end_ns = 0;
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
    std::map<Id, std::uint64_t> index_offsets;  ///< per channel
    std::uint64_t index_length = 0;
    std::uint64_t compressed = 0;
    std::uint64_t uncompressed = 0;
  };
  struct IndexEntry {
    std::uint64_t time_ns = 0;
    std::uint64_t offset = 0;  ///< in the uncompressed chunk
  };

  void put(std::string_view bytes);
  void introduce(Channel& channel);
  void end_chunk();
  void write_summary();
  [[nodiscard]] std::string_view compression_name() const;

  std::ostream& out_;
  McapCompression compression_;
  std::uint64_t written_ = 0;
  std::uint32_t crc_ = 0;                        // of all bytes put since it was set to 0
  std::vector<Schema> schemas_;                  // index: id - 1
  std::vector<Channel> channels_;                // index: id - 1
  std::string chunk_;                            // records, not yet compressed
  std::map<Id, std::vector<IndexEntry>> index_;  // of the current chunk
  std::uint64_t chunk_start_ns_ = 0;
  std::uint64_t chunk_end_ns_ = 0;
  std::vector<ChunkIndex> chunks_;
};

}  // namespace odomd::tools
