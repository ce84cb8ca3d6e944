// Recognises the files of other tools that are given in place of a candump log.

#include <algorithm>
#include <array>

#include "base/input_file.hpp"
#include "can_protocol/sources/candump.hpp"
#include "can_protocol/sources/log_reader.hpp"

namespace odomd::can {
namespace {

using namespace std::string_view_literals;

struct Format {
  std::string_view mark;  ///< first bytes of the file; for a text, of one of its first lines
  std::string_view name;
  std::string_view way;
};

constexpr auto convert = "can_logconvert FILE drive.log (python-can; python3 -m can.logconvert)"sv;
constexpr auto asc = "asc2log -I FILE -O drive.log (can-utils)"sv;
constexpr auto play = "tcpreplay -i vcan0 FILE, and record: candump -L vcan0 >drive.log"sv;
constexpr auto bag = "play its CAN topic on vcan0, and record: candump -L vcan0 >drive.log"sv;

constexpr std::array binary_formats{
    Format{"LOGG"sv, "a Vector BLF log", convert},
    Format{"MDF "sv, "an MDF measurement (MF4)", convert},
    Format{"UnFinMF"sv, "an unfinished MDF measurement (MF4)", convert},
    Format{"\x0A\x0D\x0D\x0A"sv, "a capture (pcapng)", play},
    Format{"\xD4\xC3\xB2\xA1"sv, "a capture (pcap)", play},
    Format{"\xA1\xB2\xC3\xD4"sv, "a capture (pcap)", play},
    Format{"\x4D\x3C\xB2\xA1"sv, "a capture (pcap)", play},
    Format{"#ROSBAG V"sv, "a ROS bag", bag},
    Format{"\x89MCAP0"sv, "an MCAP recording", bag},
    Format{"SQLite format 3"sv, "a database (a ROS 2 bag?)", bag},
    Format{"\xFF\xFE"sv, "a text in UTF-16", "iconv -f UTF-16 -t UTF-8 FILE >drive.log"},
};

constexpr std::array text_formats{
    Format{"date "sv, "a Vector ASC log", asc},
    Format{"base hex"sv, "a Vector ASC log", asc},
    Format{"base dec"sv, "a Vector ASC log", asc},
    Format{"***BUSMASTER"sv, "a BUSMASTER log", "save it as ASC in BUSMASTER, then asc2log"},
};
constexpr Format trc{"", "a PEAK TRC log", convert};
constexpr Format display{"", "the display of candump", "record with candump -L, or candump -l"};
constexpr Format table{
    "", "a table (CSV)",
    "SavvyCAN saves candump logs, can_logconvert converts tables of python-can; "
    "odom import takes tables of signals; else write (seconds) interface id#data "
    "for each frame"};

/// Whether a line is like "  can0  123   [4]  64 00 32 00", with or without a stamp before it.
bool is_displayed_frame(std::string_view line) {
  const std::size_t open = line.find(" [");
  const std::size_t close = line.find(']', std::min(open, line.size()));
  return close != std::string_view::npos && close - open >= 3 && close - open <= 4 &&
         std::ranges::all_of(line.substr(open + 2, close - open - 2),
                             [](char c) { return c >= '0' && c <= '9'; });
}

const Format* text_format(std::string_view line) {
  if (line.starts_with('#')) return nullptr;  // a comment
  const auto many = [line](char separator) { return std::ranges::count(line, separator) >= 3; };
  // char is unsigned on ARM.
  const auto is_control = [](unsigned char c) { return c < ' ' && c != '\t' && c != '\r'; };
  if (std::ranges::any_of(line, is_control)) return nullptr;
  for (const Format& format : text_formats)
    if (line.starts_with(format.mark)) return &format;
  if (is_displayed_frame(line)) return &display;
  if (many(',') || many('\t') || (many(';') && !line.starts_with(';'))) return &table;
  return line.starts_with(';') ? &trc : nullptr;
}

std::string describe(const Format& format) {
  return "is " + std::string(format.name) + ", not a candump log; " + std::string(format.way);
}

std::string describe(const Packing& packing) {
  return "is compressed (" + std::string(packing.name) + "), not a candump log; " +
         std::string(packing.to_pipe) + " FILE | odom ... -";
}

}  // namespace

std::optional<std::string> describe_foreign_format(std::string_view start) {
  if (const Packing* const packing = packing_of(start)) return describe(*packing);
  for (const Format& format : binary_formats)
    if (start.starts_with(format.mark)) return describe(format);
  const Format* found = nullptr;
  for (std::size_t begin = 0; begin < start.size();) {
    const std::size_t end = std::min(start.find('\n', begin), start.size());
    const std::string_view line = start.substr(begin, end - begin);
    // A frame shows that the lines before it were comments.
    if (parse_candump_line(line).good()) return std::nullopt;
    if (found == nullptr) found = text_format(line);
    begin = end + 1;
  }
  return found == nullptr ? std::nullopt : std::optional(describe(*found));
}

}  // namespace odomd::can
