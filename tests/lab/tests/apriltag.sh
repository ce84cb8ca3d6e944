# The AprilTag camera on a V4L2 device: the kernel's vivid driver, whose HDMI output is connected to
# its input. The test outputs a picture with a tag 15 cm ahead of the map's origin and 10 cm to its
# right.

camera=/dev/video0 output=/dev/video1 modules=$ODOMD_SOURCE_DIR/build/lab/unpacked
modprobe -d "$modules" vivid node_types=0x101 num_inputs=1 input_types=3 num_outputs=1 output_types=1
await 10 test -c $output
for device in $camera $output; do v4l2-ctl -d $device --set-dv-bt-timings index=0 >/dev/null; done # 640 x 480, 59.94 Hz
v4l2-ctl -d $camera -c hdmi_000_0_is_connected_to=2,osd_text_mode=2,enable_capture_scaler=0,enable_capture_composing=0
v4l2-ctl -d $output --set-fmt-video-out width=640,height=480,pixelformat=BGR3

cat >tags.toml <<'end'
camera = {on_car=false, x=0.0, y=0.0, z=1.2, pitch_deg=90}
tag = [{id=0, size=0.16, x=0.0, y=0.0, z=0.2, pitch_deg=-90, yaw_deg=180}]
end
# lens WIDTH
lens() {
  local matrix="!!opencv-matrix {rows: 3, cols: 3, dt: d, data: [600., 0., 319.5, 0., 600., 239.5, 0., 0., 1.]}"
  printf '%%YAML:1.0\n---\nimage_width: %s\nimage_height: 480\ncamera_matrix: %s\n' "$1" "$matrix"
  echo "distortion_coefficients: !!opencv-matrix {rows: 1, cols: 4, dt: d, data: [0., 0., 0., 0.]}"
}
lens 640 >lens.yaml
python3 -c '
picture = bytearray(b"\xc0" * (3 * 640 * 480))
for row in range(8):
  for column in range(8):
    inside = 0 < row < 7 and 0 < column < 7
    white = inside and 0xd5d628584 >> (42 - 6 * row - column) & 1  # tag 0 of the family
    for line in range(102 + 12 * row, 114 + 12 * row):
      at = 3 * (640 * line + 332 + 12 * column)
      picture[at:at + 36] = bytes([255 * white]) * 36
open("tag.bgr", "wb").write(picture)'
# Prints each message with its time of arrival.
python3 -c '
import socket, struct, time
door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
door.bind("camera.sock")
door.listen()
while True:
  camera = door.accept()[0]
  while message := camera.recv(81):
    print(time.monotonic_ns(), *struct.unpack("<IHHQq6dQ", message), flush=True)' >messages &
listener=$!
await 20 test -S camera.sock

example="$ODOMD_BIN_DIR/examples/apriltag_camera --tags tags.toml --socket camera.sock --lens"
says "another device is no camera" '^apriltag_camera: /dev/null: is not a camera' $example lens.yaml /dev/null
says "nor is an output" "^apriltag_camera: $output: is not a camera" $example lens.yaml $output
lens 1000 >wide.yaml
says "a size that it does not have is refused" 'not of the size in wide.yaml' timeout 20 $example wide.yaml $camera

v4l2-ctl -d $output --stream-out-mmap --stream-from tag.bgr --stream-loop >output.log 2>&1 &
writer=$!
strace -f -e trace=ioctl -o ioctls $example lens.yaml $camera >poses.csv 2>said &
seer=$!
sent() { [ "$(wc -l <messages)" -ge 20 ]; }
check "poses reach the socket" "$(head -n 5 said)" await 60 sent
reap $writer
read -r gone _ </proc/uptime
says "it says what the camera gives" "^$camera: 640 x 480 pixels, 59.94 pictures/s" cat said
blind() { grep -q '^no known tag since' said; }
check "without a tag it says so" "$(cat said)" await 30 blind
last=$(wc -l <messages)
says "a second one finds it in use" "^apriltag_camera: $camera: .*in use" timeout 20 $example lens.yaml $camera
check "and sends none" "$(tail -n 2 messages)" test "$(wc -l <messages)" = "$last"
check "they are right to 2 mm" "$(tail -n 2 messages)" \
  awk '($7 - 0.15) ^ 2 + ($8 + 0.1) ^ 2 + $9 ^ 2 > 0.002 ^ 2 {exit 1}' messages
sed -nE 's/.*DQBUF.*TIMESTAMP_MONOTONIC.*tv_sec=([0-9]+), tv_usec=([0-9]+).*/\1 \2/p' ioctls |
  awk '{printf "%d%06d000\n", $1, $2}' >stamps
check "the driver has stamped them" "$(tail -n 2 ioctls)" test -s stamps
check "their stamps are the driver's" "$(tail -n 1 messages; tail -n 1 stamps)" \
  awk 'NR == FNR {of_driver[$1]; next} !($6 in of_driver) || $4 != 0 || $6 > $1 {exit 1}' stamps messages
# Tolerance: the clock tick of /proc/uptime and of the driver.
check "and those of pictures with the tag" "gone at $gone s, $(tail -n 1 messages)" \
  awk -v gone="$gone" '$6 > 1e9 * gone + 1e7 {exit 1}' messages

echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind
ended() { ! kill -0 $seer; }
check "it ends with the camera" "$(tail -n 2 said)" await 30 ended
wait $seer
check "as a failure" "$?" test $? = 2
says "and says why" "^apriltag_camera: $camera: no more pictures; is it still connected" cat said
says "which it is not" "Path does not exist: $camera" $example lens.yaml $camera
kill $listener
modprobe -d "$modules" -r vivid
