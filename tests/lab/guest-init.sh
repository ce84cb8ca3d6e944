#!/bin/busybox sh
# The init process of the lab's machine: mounts the host's files, brings up the buses, runs the job.
#
# The host's root (9p, read-only) is below a tmpfs: the guest sees the host's files under the same
# paths and may write anywhere, but none of this reaches the host. Only /run/lab is shared: `job`
# is the command, `output` and `status` are its results.
#
# On the kernel's command line: lab.probe (boot, say so, and power off), lab.systemd (hand over to
# systemd, which runs the job as a unit).

/bin/busybox --install -s /bin
export PATH=/bin

say() { echo "lab: $*" >/dev/console; }

power_off() {
  sync
  reboot -f
  sleep 60
}

fail() {
  say "$*"
  power_off
}

mkdir -p /proc /sys /dev /lower /upper /root
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
read -r command_line </proc/cmdline

case " $command_line " in
  *" lab.probe "*) say "booted"; power_off ;;
esac

while read -r module; do
  insmod "/modules/$module" || fail "cannot load $module"
done </modules/order

mount -t 9p -o trans=virtio,version=9p2000.L,ro,cache=loose,msize=524288 host /lower ||
  fail "cannot mount the host's root"
mount -t tmpfs upper /upper
mkdir /upper/files /upper/work
mount -t overlay -o lowerdir=/lower,upperdir=/upper/files,workdir=/upper/work root /root ||
  fail "cannot lay a writable root over the host's"
mount -t proc proc /root/proc
mount -t sysfs sys /root/sys
mount -t devtmpfs dev /root/dev
ln -s /proc/self/fd /root/dev/fd
for stream in 0:stdin 1:stdout 2:stderr; do
  ln -s "/proc/self/fd/${stream%:*}" "/root/dev/${stream#*:}"
done
mkdir -p /root/dev/shm /root/dev/pts
mount -t tmpfs shm /root/dev/shm
mount -t devpts pts /root/dev/pts
mount -t tmpfs -o mode=755 run /root/run
mkdir /root/run/lab
mount -t 9p -o trans=virtio,version=9p2000.L,cache=none lab /root/run/lab ||
  fail "cannot mount the shared directory"

ip link set lo up
hostname lab

cat >/root/run/lab-job <<'end'
sh /run/lab/job >/run/lab/output 2>&1 </dev/null
echo $? >/run/lab/status.tmp
mv /run/lab/status.tmp /run/lab/status
end

# Emulated processors must not run code that the kernel is patching: QEMU before 8.1 may keep running
# a translation made during the patch, and the kernel crashes. The kernel patches its code like this
# when the first process asks for packet stamps and when the last one stops. So one process always
# asks for them, on an unused id.
chroot /root /usr/bin/candump -t a any,1F334455:DFFFFFFF >/dev/null 2>&1 </dev/null &

case " $command_line " in
  *" lab.systemd "*) . /systemd.sh ;;
esac

chroot /root /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
  HOME=/root LANG=C.UTF-8 sh /run/lab-job
power_off
