# Compares the poses of a drive that was played on a bus with the replay of its log.
#
#   awk -v wakeup=SECONDS -v gyro=ID -f compare_drive.awk drive.log received.log replay.csv poses.csv
#
# drive.log: the played log; received.log: the same frames with the kernel's stamps (both candump
# -L); replay.csv: `odom replay` of drive.log; poses.csv: the poses that odomd published.
#
# The stamps of the bus differ from those of the log by an offset (the drive is played later) and a
# jitter (the player and the machine delay frames, but never advance them). Both are measured from
# all frames: offset = smallest difference, jitter = largest less smallest.
#
# A frame takes effect at the first tick that is not before its stamp, and the ticks of the log and
# of the bus have different phases. So a frame's effect may be later or earlier than in the replay,
# depending on the jitter of its stamp. This shift, too, is measured for every frame on both grids.
# A frame that arrives while the beat wakes up may take effect at the tick before its stamp
# (`wakeup`: the beat's lateness, which is exceeded in one of a thousand ticks). After missed ticks
# the step is longer than a period, and its samples affect all of it.
#
# The bound has two parts. Along the path, a pose may be off by the distance that the car drives at
# its highest speed in the largest shift. Across the path, the heading is wrong by the change of the
# yaw rate at each frame of the gyro (with the id `gyro`), times the shift of that frame; the
# resulting distance is integrated. The bound is the sum of both and a millimetre.
#
# Prints one line: frames compared, offset, jitter, shift, highest speed, distance due to the
# heading, poses compared, largest and root mean square distance, and the bound.

function stamp(field) { return substr(field, 2, length(field) - 2) - base }

function take_in(late) {
  if (late < 0) late = -late
  if (late > shift) shift = late
}

FNR == 1 { file++ }

file <= 2 && base == 0 { base = int(substr($1, 2)) }
file == 1 { sent[++n_sent] = $3; sent_at[n_sent] = stamp($1) }
file == 2 {
  n_received++
  if ($3 != sent[n_received]) { print "frame " n_received " differs: " $3 " for " sent[n_received]; failed = 1; exit 1 }
  difference = stamp($1) - sent_at[n_received]
  if (n_received == 1 || difference < least) least = difference
  if (n_received == 1 || difference > most) most = difference
  received_at[n_received] = stamp($1)
}

file >= 3 && FNR == 1 {
  split("", column)
  count = split($0, names, ",")
  for (i = 1; i <= count; i++) column[names[i]] = i
  next
}
file >= 3 { split($0, value, ",") }
file == 3 {
  t[++n] = value[column["t"]] - base
  x[n] = value[column["x"]]; y[n] = value[column["y"]]
  yaw[n] = value[column["yaw"]]; yaw_rate[n] = value[column["yaw_rate"]]; vx[n] = value[column["vx"]]
  speed = value[column["vx"]]; if (speed < 0) speed = -speed
  if (speed > fastest) fastest = speed
}
file == 4 {
  tick_at[++ticks] = value[column["t"]] - base
  at = value[column["t"]] - base - least
  while (near < n && t[near + 1] <= at) near++
  if (near < 1 || near >= n) next
  part = (at - t[near]) / (t[near + 1] - t[near])
  dx = value[column["x"]] - (x[near] + part * (x[near + 1] - x[near]))
  dy = value[column["y"]] - (y[near] + part * (y[near + 1] - y[near]))
  square = dx * dx + dy * dy
  sum += square
  compared++
  if (square > largest) largest = square
}

END {
  if (failed) exit 1
  if (n_received != n_sent || compared == 0) { print n_received " of " n_sent " frames, " compared + 0 " poses"; exit 1 }
  jitter = most - least
  period = t[2] - t[1]

  # Both lists of ticks begin with the first pose; of earlier frames only the newest matters then.
  tick = replayed = 1
  for (i = 1; i <= n_sent; i++) {
    while (tick < ticks && tick_at[tick] < received_at[i]) tick++
    while (replayed < n && t[replayed] < sent_at[i]) replayed++
    if (tick == 1 || replayed == 1 || tick == ticks || replayed == n) continue
    take_in(tick_at[tick] - least - t[replayed])
    if (received_at[i] - tick_at[tick - 1] <= wakeup) take_in(tick_at[tick - 1] - least - t[replayed])
    begun = tick_at[tick - 1] + period - least - t[replayed]
    take_in(begun)
    if (index(sent[i], gyro "#") == 1) gyro_shift[replayed] = begun
  }
  for (i = 2; i <= n; i++) {
    heading -= gyro_shift[i] * (yaw_rate[i] - yaw_rate[i - 1])
    across_x -= vx[i] * period * heading * sin(yaw[i])
    across_y += vx[i] * period * heading * cos(yaw[i])
    square = across_x * across_x + across_y * across_y
    if (square > across) across = square
  }
  across = sqrt(across)
  bound = fastest * shift + across + 0.001
  printf "%d frames, offset %.6f s, jitter %.3f ms, shift %.3f ms, at most %.3f m/s, heading %.2f mm; %d poses, off by at most %.2f mm (rms %.2f mm) of %.2f mm\n",
    n_received, least, jitter * 1e3, shift * 1e3, fastest, across * 1e3, compared, sqrt(largest) * 1e3, sqrt(sum / compared) * 1e3, bound * 1e3
  exit !(sqrt(largest) <= bound)
}
