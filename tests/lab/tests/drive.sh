# The main task on a real bus with a real-time kernel: canplayer plays a simulated lap into odomd.
# Every tick is published or counted as missed, no frame is lost, and the poses differ from the
# log's replay only by the effect of the stamps' jitter.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../play.sh"

odom sim --scenario lap --laps 1 --out drive >/dev/null
sed 's/ can[0-9]* / vcan0 /' drive/drive.log >one.log
play_drive "one bus" one.log drive/car.toml vcan0

# A car with its wheels on one bus, its steering on another and its gyro on a third.
odom sim --scenario slalom --standstill 1 --duration 8 --out slalom >/dev/null
sed 's/ can[0-9]* \(1A[01]#\)/ vcan0 \1/; s/ can[0-9]* \(1A2#\)/ vcan1 \1/; s/ can[0-9]* \(1A3#\)/ vcan2 \1/' \
  slalom/drive.log >three.log
play_drive "three buses" three.log slalom/car.toml vcan0 vcan1 vcan2
