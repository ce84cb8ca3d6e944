// Diagnostics of logs, recordings and their other files: what is missing or damaged.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

inline constexpr auto records = std::to_array<Kind>({
    {.code = "W201",
     .name = "log_content",
     .meaning = "A log is cut off or has unused lines.",
     .fix = ""},
    {.code = "W202",
     .name = "file_content",
     .meaning = "A CSV file is cut off, or has unused rows.",
     .fix = ""},
    {.code = "W203",
     .name = "message_missing",
     .meaning = "A mapped message never comes.",
     .fix = "check that it is on the bus, and database and id"},
    {.code = "W204",
     .name = "message_without_value",
     .meaning = "A mapped message's frames give no value.",
     .fix = "check [can.e2e], valid_when, and the length in the database"},
    {.code = "W205",
     .name = "frames_cut_off",
     .meaning = "Some frames of a message end before its signals.",
     .fix = "check whether the log is cut off within a line"},
    {.code = "W206",
     .name = "frames_late",
     .meaning = "Frames are stamped far earlier than their predecessors.",
     .fix = "sort the log, or cut it where its clock was set back",
     .limits = {.most = 1.0},
     .unit = "s",
     .reason = "adapters change the order by milliseconds"},
    {.code = "W207",
     .name = "replay_without_state",
     .meaning = "A recording is replayed without the filter's state.",
     .fix = "record it again to compare bits"},
    {.code = "W208",
     .name = "no_pose",
     .meaning = "The drive gives no pose.",
     .fix = "give an initial pose (--initial, [initial] pose, or a camera pose on the log's clock) "
            "and map a wheel speed"},
    {.code = "W209",
     .name = "model_fault",
     .meaning = "The model left its valid range; do not rely on its poses.",
     .fix = "check the signals' scales and signs, the vehicle, and the databases"},
});

}  // namespace odomd::diagnostics
