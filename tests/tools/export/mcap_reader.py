"""A strict reader of MCAP files, from the specification alone (https://mcap.dev/spec): all that a file says about
itself is compared with its contents. Knows the records that an indexed file of messages has."""

from __future__ import annotations

import ctypes
import struct
import zlib
from typing import NamedTuple

MAGIC = b"\x89MCAP0\r\n"
NAMES = {
    0x01: "Header",
    0x02: "Footer",
    0x03: "Schema",
    0x04: "Channel",
    0x05: "Message",
    0x06: "Chunk",
    0x07: "MessageIndex",
    0x08: "ChunkIndex",
    0x0B: "Statistics",
    0x0E: "SummaryOffset",
    0x0F: "DataEnd",
}


class Malformed(Exception):
    pass


def check(condition: object, what: str) -> None:
    if not condition:
        raise Malformed(what)


class Schema(NamedTuple):
    id: int
    name: str
    encoding: str
    data: bytes


class Channel(NamedTuple):
    id: int
    schema_id: int
    topic: str
    message_encoding: str
    metadata: dict[str, str]


class Message(NamedTuple):
    channel_id: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class ChunkIndex(NamedTuple):
    start: int
    end: int
    offset: int
    length: int
    index_offsets: dict[int, int]
    index_length: int
    compression: str
    compressed: int
    uncompressed: int


class Record(NamedTuple):
    name: str
    offset: int  # of the opcode, in the bytes that it was read from
    length: int  # with opcode and length
    content: bytes


class Fields:
    """Takes the fields of a record one after the other."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.at = 0

    def take(self, size: int) -> bytes:
        check(self.at + size <= len(self.content), "a field reaches over the end of its record")
        self.at += size
        return self.content[self.at - size : self.at]

    def integer(self, size: int) -> int:
        return int.from_bytes(self.take(size), "little")

    def text(self) -> str:
        return self.take(self.integer(4)).decode("utf-8")

    def inner(self) -> Fields:
        return Fields(self.take(self.integer(4)))

    def more(self) -> bool:
        return self.at < len(self.content)

    def end(self) -> None:
        check(not self.more(), "a record is longer than its fields")


def records(data: bytes, begin: int, end: int) -> list[Record]:
    found = []
    at = begin
    while at < end:
        check(at + 9 <= end, "a record is cut off")
        opcode, length = struct.unpack_from("<BQ", data, at)
        check(opcode in NAMES, f"unknown opcode {opcode}")
        check(at + 9 + length <= end, "a record reaches over the end of its section")
        found.append(Record(NAMES[opcode], at, 9 + length, data[at + 9 : at + 9 + length]))
        at += 9 + length
    return found


def decompressed(compression: str, packed: bytes, size: int) -> bytes:
    if compression == "":
        return packed
    check(compression == "zstd", f"compression {compression!r}")
    zstd = ctypes.CDLL("libzstd.so.1")
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    zstd.ZSTD_decompress.argtypes = [
        ctypes.c_char_p,
        ctypes.c_size_t,
        ctypes.c_char_p,
        ctypes.c_size_t,
    ]
    buffer = ctypes.create_string_buffer(size)
    check(zstd.ZSTD_decompress(buffer, size, packed, len(packed)) == size, "zstd")
    return buffer.raw


class File:
    """A whole file, verified. `messages` are in the order of the file."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.messages: list[Message] = []
        self.chunks: list[tuple[int, ChunkIndex]] = []  # offset, and what its index must say

        check(data.startswith(MAGIC) and data.endswith(MAGIC), "magic")
        footer_length = 9 + 8 + 8 + 4
        footer_at = len(data) - len(MAGIC) - footer_length
        (footer,) = records(data, footer_at, len(data) - len(MAGIC))
        check(footer.name == "Footer", "no footer")
        fields = Fields(footer.content)
        summary_start, offsets_start, summary_crc = (
            fields.integer(8),
            fields.integer(8),
            fields.integer(4),
        )
        check(summary_crc == zlib.crc32(data[summary_start : len(data) - len(MAGIC) - 4]), "CRC of the summary")

        self._read_data(records(data, len(MAGIC), summary_start))
        self._read_summary(records(data, summary_start, offsets_start))
        self._read_offsets(records(data, offsets_start, footer_at), summary_start, offsets_start)

    # The data section --------------------------------------------------------------------------

    def _read_data(self, found: list[Record]) -> None:
        check(found[0].name == "Header", "no header")
        fields = Fields(found[0].content)
        self.profile = fields.text()
        self.library = fields.text()
        fields.end()
        check(found[-1].name == "DataEnd", "the data section does not end with DataEnd")
        crc = int.from_bytes(found[-1].content, "little")
        check(crc == zlib.crc32(self.data[: found[-1].offset]), "CRC of the data section")
        at = 1
        while at < len(found) - 1:
            check(found[at].name == "Chunk", f"{found[at].name} outside of a chunk")
            indices = []
            chunk = found[at]
            at += 1
            while found[at].name == "MessageIndex":
                indices.append(found[at])
                at += 1
            self._read_chunk(chunk, indices)

    def _read_chunk(self, chunk: Record, indices: list[Record]) -> None:
        fields = Fields(chunk.content)
        start, end, size, crc = (fields.integer(n) for n in (8, 8, 8, 4))
        compression = fields.text()
        packed = fields.take(fields.integer(8))
        fields.end()
        content = decompressed(compression, packed, size)
        check(len(content) == size, "uncompressed size")
        check(crc == zlib.crc32(content), "CRC of a chunk")

        places: dict[int, list[tuple[int, int]]] = {}
        times = []
        for record in records(content, 0, len(content)):
            if record.name == "Schema":
                self._take_schema(record)
            elif record.name == "Channel":
                self._take_channel(record)
            else:
                check(record.name == "Message", f"{record.name} in a chunk")
                message = self._take_message(record)
                places.setdefault(message.channel_id, []).append((message.log_time, record.offset))
                times.append(message.log_time)
        check(times, "a chunk without a message")
        check((start, end) == (min(times), max(times)), "times of a chunk")

        offsets = {}
        for index in indices:
            fields = Fields(index.content)
            channel = fields.integer(2)
            entries = fields.inner()
            fields.end()
            listed = []
            while entries.more():
                listed.append((entries.integer(8), entries.integer(8)))
            check(channel not in offsets, "two message indices of one channel")
            check(listed == places.get(channel), f"message index of channel {channel}")
            offsets[channel] = index.offset
        check(offsets.keys() == places.keys(), "a channel of a chunk has no message index")
        self.chunks.append(
            (
                chunk.offset,
                ChunkIndex(
                    *(start, end, chunk.offset, chunk.length, offsets),
                    *(sum(i.length for i in indices), compression, len(packed), size),
                ),
            )
        )

    def _take_schema(self, record: Record) -> None:
        schema = read_schema(record)
        check(schema.id != 0, "schema 0")
        check(self.schemas.setdefault(schema.id, schema) == schema, "two schemas of one id")

    def _take_channel(self, record: Record) -> None:
        channel = read_channel(record)
        check(channel.schema_id in self.schemas, "a channel before its schema")
        check(self.channels.setdefault(channel.id, channel) == channel, "two channels of one id")

    def _take_message(self, record: Record) -> Message:
        fields = Fields(record.content)
        channel, sequence, logged, published = (fields.integer(n) for n in (2, 4, 8, 8))
        message = Message(channel, sequence, logged, published, fields.content[fields.at :])
        check(message.channel_id in self.channels, "a message before its channel")
        self.messages.append(message)
        return message

    # The summary -------------------------------------------------------------------------------

    def _read_summary(self, found: list[Record]) -> None:
        names = [record.name for record in found]
        check(len(set(names)) == sum(a != b for a, b in zip([""] + names, names)), "summary not grouped")
        of = {name: [r for r in found if r.name == name] for name in set(names)}
        self.groups = {
            name: (group[0].offset, sum(r.length for r in group)) for name, group in of.items()
        }
        check({s.id: s for s in map(read_schema, of.get("Schema", []))} == self.schemas, "schemas")
        check({c.id: c for c in map(read_channel, of.get("Channel", []))} == self.channels, "channels")
        check(
            [read_chunk_index(r) for r in of.get("ChunkIndex", [])] == [c for _, c in self.chunks],
            "chunk indices",
        )
        check(len(of.get("Statistics", [])) == 1, "statistics")
        self._check_statistics(Fields(of["Statistics"][0].content))

    def _check_statistics(self, fields: Fields) -> None:
        counts: dict[int, int] = {}
        for message in self.messages:
            counts[message.channel_id] = counts.get(message.channel_id, 0) + 1
        times = [message.log_time for message in self.messages] or [0]
        expected = [
            *(len(self.messages), len(self.schemas), len(self.channels), 0, 0, len(self.chunks)),
            *(min(times), max(times)),
        ]
        said = [fields.integer(n) for n in (8, 2, 4, 4, 4, 4, 8, 8)]
        check(said == expected, f"statistics say {said}, there is {expected}")
        entries = fields.inner()
        fields.end()
        listed = {}
        while entries.more():
            channel = entries.integer(2)
            listed[channel] = entries.integer(8)
        check(listed == counts, "message counts of the channels")

    def _read_offsets(self, found: list[Record], begin: int, end: int) -> None:
        listed = {}
        for record in found:
            check(record.name == "SummaryOffset", f"{record.name} among the summary offsets")
            fields = Fields(record.content)
            name = NAMES[fields.integer(1)]
            listed[name] = (fields.integer(8), fields.integer(8))
            fields.end()
            check(begin <= listed[name][0] < end, "a summary offset outside of the summary")
        check(listed == self.groups, "summary offsets")

    # What is in it -----------------------------------------------------------------------------

    def topics(self) -> dict[str, Channel]:
        named = {channel.topic: channel for channel in self.channels.values()}
        check(len(named) == len(self.channels), "two channels of one topic")
        return named

    def on(self, topic: str) -> list[Message]:
        channel = self.topics()[topic]
        return [message for message in self.messages if message.channel_id == channel.id]


def read_schema(record: Record) -> Schema:
    fields = Fields(record.content)
    schema = Schema(fields.integer(2), fields.text(), fields.text(), fields.take(fields.integer(4)))
    fields.end()
    return schema


def read_channel(record: Record) -> Channel:
    fields = Fields(record.content)
    id_, schema = fields.integer(2), fields.integer(2)
    topic, encoding = fields.text(), fields.text()
    entries = fields.inner()
    fields.end()
    metadata = {}
    while entries.more():
        name = entries.text()
        metadata[name] = entries.text()
    return Channel(id_, schema, topic, encoding, metadata)


def read_chunk_index(record: Record) -> ChunkIndex:
    fields = Fields(record.content)
    start, end, offset, length = (fields.integer(8) for _ in range(4))
    entries = fields.inner()
    offsets = {}
    while entries.more():
        channel = entries.integer(2)
        offsets[channel] = entries.integer(8)
    index_length = fields.integer(8)
    compression = fields.text()
    index = ChunkIndex(
        *(start, end, offset, length, offsets, index_length, compression),
        *(fields.integer(8), fields.integer(8)),
    )
    fields.end()
    return index
