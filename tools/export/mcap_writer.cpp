#include "tools/export/export.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <concepts>
#include <ostream>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
constexpr std::string_view compression = "zstd";

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

std::uint32_t size32(std::size_t size) {
  if (size > 0xFFFFFFFFU) throw std::runtime_error("MCAP: a part of the file exceeds 4 GB");
  return static_cast<std::uint32_t>(size);
}

void append(std::string& out, std::unsigned_integral auto value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFFU);
}

/// Length, then the text or map.
void append(std::string& out, std::string_view text) {
  append(out, size32(text.size()));
  out += text;
}

/// The fields of a record one after the other; integers are little endian.
std::string bytes_of(const auto&... fields) {
  std::string bytes;
  (append(bytes, fields), ...);
  return bytes;
}

std::string record(Opcode opcode, std::string_view content) {
  return bytes_of(static_cast<std::uint8_t>(opcode), std::uint64_t{content.size()}).append(content);
}

std::string compressed(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(size) != 0)
    throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

/// The JSON schema of values like this one; all members of an object are required.
Json schema_of(const Json& value) {
  if (value.is_string()) return {{"type", "string"}};
  if (value.is_number()) return {{"type", value.is_number_integer() ? "integer" : "number"}};
  if (value.is_array()) return {{"type", "array"}, {"items", schema_of(value.at(0))}};
  Json properties = Json::object(), names = Json::array();
  for (const auto& [name, member] : value.items()) {
    properties[name] = schema_of(member);
    names.push_back(name);
  }
  return {{"type", "object"}, {"properties", properties}, {"required", names}};
}

}  // namespace

McapWriter::McapWriter(std::ostream& out, std::string_view library) : out_(out) {
  put(magic);
  constexpr std::string_view no_profile;  // a ROS profile implies ROS serialisation
  put(record(Opcode::header, bytes_of(no_profile, library)));
}

void McapWriter::put(std::string_view bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  written_ += bytes.size();
  crc_ = crc32(crc_, bytes);
}

// Writes schema and channel before the first message that needs them.
McapWriter::Channel& McapWriter::channel_for(const std::string& topic, const std::string& schema,
                                             const Json& message) {
  const auto [channel, is_new] =
      channels_.try_emplace(topic, Channel{static_cast<Id>(channels_.size() + 1)});
  if (!is_new) return channel->second;
  const auto [known, is_new_schema] =
      schemas_.try_emplace(schema, static_cast<Id>(schemas_.size() + 1));
  if (is_new_schema) {
    Json text{{"title", schema}};
    text.update(schema_of(message));
    const std::string added =
        record(Opcode::schema, bytes_of(known->second, schema, "jsonschema", text.dump()));
    chunk_ += added;
    schema_records_ += added;
  }
  constexpr std::string_view encoding = "json", no_metadata;
  const std::string added = record(
      Opcode::channel, bytes_of(channel->second.id, known->second, topic, encoding, no_metadata));
  chunk_ += added;
  channel_records_ += added;
  return channel->second;
}

void McapWriter::write(const std::string& topic, const std::string& schema, std::int64_t time_ns,
                       const Json& message) {
  if (time_ns < 0) throw std::invalid_argument("a time lies before 0, which MCAP cannot store");
  Channel& channel = channel_for(topic, schema, message);
  const auto time = static_cast<std::uint64_t>(time_ns);
  if (index_.empty()) chunk_start_ns_ = chunk_end_ns_ = time;
  chunk_start_ns_ = std::min(chunk_start_ns_, time);
  chunk_end_ns_ = std::max(chunk_end_ns_, time);
  index_[channel.id] += bytes_of(time, std::uint64_t{chunk_.size()});
  const std::string head =
      bytes_of(channel.id, channel.messages++, time, time);  // logged, published
  chunk_ += record(Opcode::message, head + message.dump());
  if (chunk_.size() >= chunk_size) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  const std::string packed = compressed(chunk_);
  const std::uint64_t offset = written_, size = chunk_.size(), packed_size = packed.size();
  put(record(Opcode::chunk, bytes_of(chunk_start_ns_, chunk_end_ns_, size, crc32(0, chunk_),
                                     compression, packed_size) +
                                packed));
  const std::uint64_t length = written_ - offset;

  std::string index_offsets;
  for (const auto& [channel, entries] : index_) {
    index_offsets += bytes_of(channel, written_);
    put(record(Opcode::message_index, bytes_of(channel, entries)));
  }
  const std::uint64_t index_length = written_ - offset - length;
  chunks_.push_back(
      {chunk_start_ns_, chunk_end_ns_,
       bytes_of(offset, length, index_offsets, index_length, compression, packed_size, size)});
  chunk_.clear();
  index_.clear();
}

McapStatistics McapWriter::finish() {
  end_chunk();
  put(record(Opcode::data_end, bytes_of(crc_)));
  write_summary();
  put(magic);
  McapStatistics statistics{.bytes = written_,
                            .topics = static_cast<std::uint32_t>(channels_.size())};
  for (const auto& [topic, channel] : channels_) statistics.messages += channel.messages;
  return statistics;
}

void McapWriter::write_summary() {
  const std::uint64_t summary_start = written_;
  crc_ = 0;
  std::string offsets;
  const auto put_group = [&](Opcode opcode, const std::string& records) {
    if (records.empty()) return;
    const std::uint64_t start = written_;
    put(records);
    offsets += record(Opcode::summary_offset, bytes_of(static_cast<std::uint8_t>(opcode), start,
                                                       std::uint64_t{records.size()}));
  };
  put_group(Opcode::schema, schema_records_);
  put_group(Opcode::channel, channel_records_);

  std::string counts, chunks;
  std::uint64_t messages = 0;
  for (const auto& [topic, channel] : channels_) {
    messages += channel.messages;
    counts += bytes_of(channel.id, std::uint64_t{channel.messages});
  }
  for (const ChunkIndex& chunk : chunks_)
    chunks +=
        record(Opcode::chunk_index, bytes_of(chunk.start_ns, chunk.end_ns).append(chunk.rest));
  constexpr std::uint32_t attachments = 0, metadata = 0;
  const std::uint64_t start_ns = chunks_.empty() ? 0 : chunks_.front().start_ns;
  const std::uint64_t end_ns = chunks_.empty() ? 0 : chunks_.back().end_ns;
  put_group(Opcode::statistics,
            record(Opcode::statistics,
                   bytes_of(messages, static_cast<std::uint16_t>(schemas_.size()),
                            static_cast<std::uint32_t>(channels_.size()), attachments, metadata,
                            size32(chunks_.size()), start_ns, end_ns, counts)));
  put_group(Opcode::chunk_index, chunks);

  const std::uint64_t offsets_start = written_;
  put(offsets);
  // The checksum also covers the footer, up to the checksum itself.
  const std::string footer = record(Opcode::footer, bytes_of(summary_start, offsets_start, crc_));
  put(std::string_view(footer).substr(0, footer.size() - sizeof crc_));
  put(bytes_of(crc_));
}

}  // namespace odomd::tools
