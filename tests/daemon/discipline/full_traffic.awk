# Makes full traffic from a car's log (candump -L): adds unmapped frames, evenly spaced, up to a
# total of `rate` per second, on four buses. Of sixteen, one has an extended identifier and one is
# CAN FD.
#
#   awk -v rate=8000 -v own=500 -f full_traffic.awk drive.log
#
# `own` is the rate of the log's own frames; `count` is a file for the number of frames written.
# Stamps are in microseconds.
function stamp(microseconds) {
  return sprintf("(%d.%06d)", int(microseconds / 1000000), microseconds % 1000000)
}

function other(n, microseconds) {
  data = sprintf("%04X%04X%04X%04X", n % 65536, n * 7 % 65536, n * 31 % 65536, n * 131 % 65536)
  kind = n % 16
  if (kind == 3)
    name = sprintf("18DA%04X#", n % 48)
  else if (kind == 11)
    name = sprintf("%03X##1", 1024 + n % 48)
  else
    name = sprintf("%03X#", 768 + n % 48)
  print stamp(microseconds) " can" n % 4 " " name data
}

{
  split(substr($1, 2), parts, /[.)]/)
  now = parts[1] * 1000000 + parts[2]
  if (NR == 1) begin = now
  for (; begin + int(n * 1000000 / (rate - own)) <= now; ++n)
    other(n, begin + int(n * 1000000 / (rate - own)))
  print
}

END {
  if (count) print n + NR >count
}
