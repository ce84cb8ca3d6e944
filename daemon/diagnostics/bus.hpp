// Diagnostics of CAN buses: their interfaces and their traffic.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

inline constexpr auto bus = std::to_array<Kind>({
    {.code = "W701",
     .name = "interface_missing",
     .meaning = "A CAN interface does not exist.",
     .fix = "connect it and load its driver; ip -brief link show lists what there is"},
    {.code = "W702",
     .name = "interface_not_can",
     .meaning = "An interface is not CAN.",
     .fix = "name another; ip -brief link show type can lists them"},
    {.code = "W703",
     .name = "interface_down",
     .meaning = "A CAN interface is down.",
     .fix = "sudo ip link set {INTERFACE} up"},
    {.code = "W704",
     .name = "no_bit_rate",
     .meaning = "A CAN controller has no bit rate.",
     .fix = "sudo ip link set {INTERFACE} type can bitrate 500000 restart-ms 100, with the bus's "
            "bit rate, and set it up"},
    {.code = "W705",
     .name = "no_restart",
     .meaning = "A CAN controller does not restart after bus-off.",
     .fix = "set it down, then sudo ip link set {INTERFACE} type can restart-ms 100, and up again"},
    {.code = "W706",
     .name = "bus_errors",
     .meaning = "A CAN controller sees many errors.",
     .fix =
         "check the bit rate of {INTERFACE}, the bus's two terminating resistors and the wiring"},
    {.code = "W707",
     .name = "bus_off",
     .meaning = "A CAN controller has left the bus.",
     .fix = "check bit rate and wiring, then set {INTERFACE} down and up again"},
    {.code = "W708",
     .name = "no_can_fd",
     .meaning = "A mapped message is CAN FD, but the interface is not.",
     .fix =
         "set it down, then sudo ip link set {INTERFACE} type can bitrate 500000 dbitrate 2000000 "
         "fd on, with the rates of the bus (a virtual one: mtu 72), and up again"},
    {.code = "W709",
     .name = "nobody_acknowledges",
     .meaning = "A listen-only interface hears nothing, or one frame repeatedly.",
     .fix = "if the bus has only one other node, set it down, then sudo ip link set {INTERFACE} "
            "type can listen-only off, and up again"},
    {.code = "W711",
     .name = "no_frames",
     .meaning = "No frame comes.",
     .fix = "check that the car is on, the wiring, and the bit rate"},
    {.code = "W712",
     .name = "other_database",
     .meaning = "Frames come, but none of the mapped messages.",
     .fix = "check that can.dbc names this car's database, and can.source the right bus"},
    {.code = "W713",
     .name = "other_id_format",
     .meaning = "A mapped message's identifier comes in the other format.",
     .fix = "give its BO_ in the database the number {NUMBER}"},
    {.code = "W714",
     .name = "other_rate",
     .meaning = "A mapped message's rate differs from the database.",
     .fix = "if its sender is right, write {LINE} in the database",
     .limits = {0.5, 1.5},
     .reason = "ratio to GenMsgCycleTime"},
    {.code = "W715",
     .name = "slower_than_timeout",
     .meaning = "A mapped message is rarer than its signals' timeout.",
     .fix = "set timeout of {KEY}"},
});

}  // namespace odomd::diagnostics
