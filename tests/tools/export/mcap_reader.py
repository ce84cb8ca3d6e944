"""A strict reader of MCAP files, from the specification alone (https://mcap.dev/spec): all that a file says about
itself is compared with its contents. Knows the records that an indexed file of messages has."""

from __future__ import annotations

import ctypes
import re
import struct
import zlib
from collections import namedtuple
from typing import Any, NamedTuple

MAGIC = b"\x89MCAP0\r\n"
# Opcode, name and fields of a record: B, H, I and Q are integers, s is a text, b and q are bytes that follow their
# count of four or eight bytes, {..} is a list of pairs, * is the rest.
RECORDS = {
    0x01: ("Header", "ss"),
    0x02: ("Footer", "QQI"),
    0x03: ("Schema", "Hssb"),
    0x04: ("Channel", "HHss{ss}"),
    0x05: ("Message", "HIQQ*"),
    0x06: ("Chunk", "QQQIsq"),
    0x07: ("MessageIndex", "H{QQ}"),
    0x08: ("ChunkIndex", "QQQQ{HQ}QsQQ"),
    0x0B: ("Statistics", "QHIIIIQQ{HQ}"),
    0x0E: ("SummaryOffset", "BQQ"),
    0x0F: ("DataEnd", "I"),
}
SIZES = {"B": 1, "H": 2, "I": 4, "Q": 8}


class Malformed(Exception):
    pass


def check(condition: object, what: str) -> None:
    if not condition:
        raise Malformed(what)


Schema = namedtuple("Schema", "id name encoding data")
Channel = namedtuple("Channel", "id schema_id topic message_encoding metadata")
Message = namedtuple("Message", "channel_id sequence log_time publish_time data")
ChunkIndex = namedtuple(
    "ChunkIndex", "start end offset length index_offsets index_length compression compressed uncompressed"
)


class Record(NamedTuple):
    name: str
    offset: int  # of the opcode, within the bytes that were read
    length: int  # including opcode and length
    fields: list[Any]


class Bytes:
    """Takes fields one after the other."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.at = 0

    def take(self, size: int) -> bytes:
        check(self.at + size <= len(self.content), "a field reaches over the end of its record")
        self.at += size
        return self.content[self.at - size : self.at]

    def integer(self, size: int) -> int:
        return int.from_bytes(self.take(size), "little")

    def field(self, kind: str) -> Any:
        if kind in SIZES:
            return self.integer(SIZES[kind])
        if kind == "*":
            return self.take(len(self.content) - self.at)
        data = self.take(self.integer(8 if kind == "q" else 4))
        if kind in "bq":
            return data
        if kind == "s":
            return data.decode("utf-8")
        pairs, inner = [], Bytes(data)
        while inner.at < len(data):
            pairs.append((inner.field(kind[1]), inner.field(kind[2])))
        return pairs

    def fields(self, kinds: str) -> list[Any]:
        found = [self.field(kind) for kind in re.findall(r"{..}|.", kinds)]
        check(self.at == len(self.content), "a record is longer than its fields")
        return found


def records(data: bytes, begin: int, end: int) -> list[Record]:
    found = []
    at = begin
    while at < end:
        check(at + 9 <= end, "a record is cut off")
        opcode, length = struct.unpack_from("<BQ", data, at)
        check(opcode in RECORDS, f"unknown opcode {opcode}")
        check(at + 9 + length <= end, "a record reaches over the end of its section")
        name, kinds = RECORDS[opcode]
        found.append(Record(name, at, 9 + length, Bytes(data[at + 9 : at + 9 + length]).fields(kinds)))
        at += 9 + length
    return found


def decompressed(compression: str, packed: bytes, size: int) -> bytes:
    if compression == "":
        return packed
    check(compression == "zstd", f"compression {compression!r}")
    zstd = ctypes.CDLL("libzstd.so.1")
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    zstd.ZSTD_decompress.argtypes = [ctypes.c_char_p, ctypes.c_size_t] * 2
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
        end = len(data) - len(MAGIC)
        footer_at = end - (9 + 8 + 8 + 4)
        (footer,) = records(data, footer_at, end)
        check(footer.name == "Footer", "no footer")
        summary_start, offsets_start, summary_crc = footer.fields
        check(summary_crc == zlib.crc32(data[summary_start : end - 4]), "CRC of the summary")
        self._read_data(records(data, len(MAGIC), summary_start))
        groups = self._read_summary(records(data, summary_start, offsets_start))

        offsets: dict[str, list[int]] = {}
        for record in records(data, offsets_start, footer_at):
            check(record.name == "SummaryOffset", f"{record.name} among the summary offsets")
            offsets[RECORDS[record.fields[0]][0]] = record.fields[1:]
        check(offsets == groups, "summary offsets")

    def _read_data(self, found: list[Record]) -> None:
        check(found[0].name == "Header", "no header")
        self.profile, self.library = found[0].fields
        check(found[-1].name == "DataEnd", "the data section does not end with DataEnd")
        check(found[-1].fields == [zlib.crc32(self.data[: found[-1].offset])], "CRC of the data section")
        at = 1
        while at < len(found) - 1:
            check(found[at].name == "Chunk", f"{found[at].name} outside of a chunk")
            chunk = found[at]
            begin = at = at + 1
            while found[at].name == "MessageIndex":
                at += 1
            self._read_chunk(chunk, found[begin:at])

    def _read_chunk(self, chunk: Record, indices: list[Record]) -> None:
        start, end, size, crc, compression, packed = chunk.fields
        content = decompressed(compression, packed, size)
        check(len(content) == size, "uncompressed size")
        check(crc == zlib.crc32(content), "CRC of a chunk")
        places: dict[int, list[tuple[int, int]]] = {}
        for record in records(content, 0, len(content)):
            if record.name == "Schema":
                schema = Schema(*record.fields)
                check(schema.id != 0, "schema 0")
                check(self.schemas.setdefault(schema.id, schema) == schema, "two schemas of one id")
            elif record.name == "Channel":
                channel = Channel(*record.fields)
                check(channel.schema_id in self.schemas, "a channel before its schema")
                check(self.channels.setdefault(channel.id, channel) == channel, "two channels of one id")
            else:
                check(record.name == "Message", f"{record.name} in a chunk")
                message = Message(*record.fields)
                check(message.channel_id in self.channels, "a message before its channel")
                self.messages.append(message)
                places.setdefault(message.channel_id, []).append((message.log_time, record.offset))
        times = [time for listed in places.values() for time, _ in listed]
        check(times, "a chunk without a message")
        check((start, end) == (min(times), max(times)), "times of a chunk")
        check(sorted(index.fields for index in indices) == sorted([c, p] for c, p in places.items()), "message indices")
        index = ChunkIndex(
            *(start, end, chunk.offset, chunk.length, [(i.fields[0], i.offset) for i in indices]),
            *(sum(i.length for i in indices), compression, len(packed), size),
        )
        self.chunks.append((chunk.offset, index))

    def _read_summary(self, found: list[Record]) -> dict[str, list[int]]:
        names = [record.name for record in found]
        check(len(set(names)) == sum(a != b for a, b in zip([""] + names, names)), "summary not grouped")
        of = {name: [r for r in found if r.name == name] for name in set(names)}
        said = {name: [r.fields for r in group] for name, group in of.items()}
        check({s[0]: Schema(*s) for s in said.get("Schema", [])} == self.schemas, "schemas")
        check({c[0]: Channel(*c) for c in said.get("Channel", [])} == self.channels, "channels")
        check([ChunkIndex(*c) for c in said.get("ChunkIndex", [])] == [c for _, c in self.chunks], "chunk indices")
        ids = [message.channel_id for message in self.messages]
        times = [message.log_time for message in self.messages] or [0]
        *totals, by_channel = said["Statistics"][0]
        expected = [
            *(len(self.messages), len(self.schemas), len(self.channels), 0, 0, len(self.chunks)),
            *(min(times), max(times)),
        ]
        check(len(said["Statistics"]) == 1 and totals == expected, f"statistics say {totals}, there is {expected}")
        check(dict(by_channel) == {id_: ids.count(id_) for id_ in set(ids)}, "message counts of the channels")
        return {name: [group[0].offset, sum(r.length for r in group)] for name, group in of.items()}

    def topics(self) -> dict[str, Channel]:
        named = {channel.topic: channel for channel in self.channels.values()}
        check(len(named) == len(self.channels), "two channels of one topic")
        return named

    def on(self, topic: str) -> list[Message]:
        channel = self.topics()[topic]
        return [message for message in self.messages if message.channel_id == channel.id]
