#include "tools/export/mcap_writer.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <ostream>
#include <stdexcept>
#include <type_traits>

namespace odomd::tools {
namespace {

constexpr std::string_view magic{"\x89MCAP0\r\n", 8};

// Large enough to compress well, small enough to read quickly.
constexpr std::size_t chunk_size = 1U << 20U;

enum class Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  statistics = 0x0B,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

std::uint32_t crc32(std::uint32_t crc, std::string_view bytes) {
  if (bytes.empty()) return crc;
  return static_cast<std::uint32_t>(
      ::crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

template <typename T>
void put_integer(std::string& out, T value) {
  static_assert(std::is_unsigned_v<T>);
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFFU);
}

std::uint32_t size32(std::size_t size) {
  if (size > 0xFFFFFFFFU) throw std::runtime_error("MCAP: a part of the file exceeds 4 GB");
  return static_cast<std::uint32_t>(size);
}

void put_string(std::string& out, std::string_view text) {
  put_integer(out, size32(text.size()));
  out += text;
}

std::string record(Opcode opcode, std::string_view content) {
  std::string bytes(1, static_cast<char>(opcode));
  put_integer(bytes, std::uint64_t{content.size()});
  bytes += content;
  return bytes;
}

std::string compressed(McapCompression compression, const std::string& bytes) {
  if (compression == McapCompression::none) return bytes;
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(size) != 0)
    throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

}  // namespace

McapWriter::McapWriter(std::ostream& out, McapCompression compression, std::string_view library)
    : out_(out), compression_(compression) {
  put(magic);
  std::string header;
  put_string(header, "");  // no profile: that of ROS implies ROS serialisation
  put_string(header, library);
  put(record(Opcode::header, header));
}

std::string_view McapWriter::compression_name() const {
  return compression_ == McapCompression::zstd ? "zstd" : "";
}

void McapWriter::put(std::string_view bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  written_ += bytes.size();
  crc_ = crc32(crc_, bytes);
}

McapWriter::Id McapWriter::add_schema(std::string_view name, std::string_view text) {
  const auto id = static_cast<Id>(schemas_.size() + 1);
  std::string content;
  put_integer(content, id);
  put_string(content, name);
  put_string(content, "jsonschema");
  put_string(content, text);
  schemas_.push_back({record(Opcode::schema, content)});
  return id;
}

McapWriter::Id McapWriter::add_channel(std::string_view topic, Id schema) {
  const auto id = static_cast<Id>(channels_.size() + 1);
  std::string content;
  put_integer(content, id);
  put_integer(content, schema);
  put_string(content, topic);
  put_string(content, "json");
  put_string(content, "");  // no metadata
  channels_.push_back({record(Opcode::channel, content), schema});
  return id;
}

// Writes schema and channel before the first message that needs them.
void McapWriter::introduce(Channel& channel) {
  if (channel.written) return;
  Schema& schema = schemas_[channel.schema - 1U];
  if (!schema.written) chunk_ += schema.record;
  schema.written = true;
  chunk_ += channel.record;
  channel.written = true;
}

void McapWriter::write(Id id, std::int64_t time_ns, std::string_view json) {
  Channel& channel = channels_[id - 1U];
  introduce(channel);
  const auto time = static_cast<std::uint64_t>(time_ns);
  if (index_.empty()) chunk_start_ns_ = chunk_end_ns_ = time;
  chunk_start_ns_ = std::min(chunk_start_ns_, time);
  chunk_end_ns_ = std::max(chunk_end_ns_, time);
  index_[id].push_back({time, chunk_.size()});

  chunk_ += static_cast<char>(Opcode::message);
  constexpr std::size_t fixed = 2 + 4 + 8 + 8;
  put_integer(chunk_, std::uint64_t{fixed + json.size()});
  put_integer(chunk_, id);
  put_integer(chunk_, channel.messages++);
  put_integer(chunk_, time);  // logged
  put_integer(chunk_, time);  // published
  chunk_ += json;
  if (chunk_.size() >= chunk_size) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  const std::string packed = compressed(compression_, chunk_);
  ChunkIndex entry;
  entry.start_ns = chunk_start_ns_;
  entry.end_ns = chunk_end_ns_;
  entry.offset = written_;
  entry.compressed = packed.size();
  entry.uncompressed = chunk_.size();
  std::string content;
  put_integer(content, entry.start_ns);
  put_integer(content, entry.end_ns);
  put_integer(content, entry.uncompressed);
  put_integer(content, crc32(0, chunk_));
  put_string(content, compression_name());
  put_integer(content, entry.compressed);
  content += packed;
  put(record(Opcode::chunk, content));
  entry.length = written_ - entry.offset;

  for (const auto& [channel, entries] : index_) {
    entry.index_offsets[channel] = written_;
    std::string array;
    for (const IndexEntry& one : entries) {
      put_integer(array, one.time_ns);
      put_integer(array, one.offset);
    }
    std::string index;
    put_integer(index, channel);
    put_string(index, array);
    put(record(Opcode::message_index, index));
  }
  entry.index_length = written_ - entry.offset - entry.length;
  chunks_.push_back(std::move(entry));
  chunk_.clear();
  index_.clear();
}

McapStatistics McapWriter::finish() {
  end_chunk();
  std::string end;
  put_integer(end, crc_);
  put(record(Opcode::data_end, end));
  write_summary();
  put(magic);
  McapStatistics statistics;
  statistics.bytes = written_;
  for (const Channel& channel : channels_) {
    statistics.messages += channel.messages;
    statistics.topics += channel.written ? 1 : 0;
  }
  return statistics;
}

void McapWriter::write_summary() {
  const std::uint64_t summary_start = written_;
  crc_ = 0;
  std::string offsets;
  std::uint64_t group_start = written_;
  const auto end_group = [&](Opcode opcode) {
    if (written_ == group_start) return;
    std::string content(1, static_cast<char>(opcode));
    put_integer(content, group_start);
    put_integer(content, written_ - group_start);
    offsets += record(Opcode::summary_offset, content);
    group_start = written_;
  };

  std::string counts;
  std::uint64_t messages = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  for (const Schema& schema : schemas_) {
    if (!schema.written) continue;
    put(schema.record);
    ++schema_count;
  }
  end_group(Opcode::schema);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!channels_[i].written) continue;
    put(channels_[i].record);
    ++channel_count;
    messages += channels_[i].messages;
    put_integer(counts, static_cast<Id>(i + 1));
    put_integer(counts, std::uint64_t{channels_[i].messages});
  }
  end_group(Opcode::channel);

  std::string statistics;
  put_integer(statistics, messages);
  put_integer(statistics, schema_count);
  put_integer(statistics, channel_count);
  put_integer(statistics, std::uint32_t{0});  // attachments
  put_integer(statistics, std::uint32_t{0});  // metadata
  put_integer(statistics, size32(chunks_.size()));
  std::uint64_t start_ns = chunks_.empty() ? 0 : chunks_.front().start_ns;
  std::uint64_t end_ns = 0;
  for (const ChunkIndex& chunk : chunks_) {
    start_ns = std::min(start_ns, chunk.start_ns);
    end_ns = std::max(end_ns, chunk.end_ns);
  }
  put_integer(statistics, start_ns);
  put_integer(statistics, end_ns);
  put_string(statistics, counts);
  put(record(Opcode::statistics, statistics));
  end_group(Opcode::statistics);

  for (const ChunkIndex& chunk : chunks_) {
    std::string content;
    put_integer(content, chunk.start_ns);
    put_integer(content, chunk.end_ns);
    put_integer(content, chunk.offset);
    put_integer(content, chunk.length);
    std::string map;
    for (const auto& [channel, offset] : chunk.index_offsets) {
      put_integer(map, channel);
      put_integer(map, offset);
    }
    put_string(content, map);
    put_integer(content, chunk.index_length);
    put_string(content, compression_name());
    put_integer(content, chunk.compressed);
    put_integer(content, chunk.uncompressed);
    put(record(Opcode::chunk_index, content));
  }
  end_group(Opcode::chunk_index);

  const std::uint64_t offsets_start = written_;
  put(offsets);
  // The checksum covers the footer before the checksum.
  std::string footer;
  put_integer(footer, summary_start);
  put_integer(footer, offsets_start);
  std::string begin(1, static_cast<char>(Opcode::footer));
  put_integer(begin, std::uint64_t{footer.size() + sizeof crc_});
  put(begin + footer);
  std::string crc;
  put_integer(crc, crc_);
  put(crc);
}

}  // namespace odomd::tools
