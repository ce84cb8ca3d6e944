# The machine with systemd as init. guest-init.sh sources this, with the host's files in /root: it
# prepares the files that systemd needs, and hands over to it.
#
# No service of the host runs, even if it is installed and enabled there: only the services of
# systemd listed below, as on a small car computer, and the unit of the job.

kept='systemd-journald.service systemd-journald.socket systemd-journald-dev-log.socket
  systemd-udevd.service systemd-udevd-control.socket systemd-udevd-kernel.socket
  systemd-udev-trigger.service'

[ -x /root/bin/udevadm ] || fail "udev is missing; tools/dependencies.sh test installs it"

units=/root/etc/systemd/system
mount -t tmpfs -o mode=755 units $units
for unit in /root/lib/systemd/system/*.target.wants/*; do
  unit=${unit##*/}
  case " $(echo $kept) " in
    *" $unit "*) ;;
    *) ln -sf /dev/null "$units/$unit" ;;
  esac
done

mkdir -p /root/run/systemd/system-generators /root/run/systemd/journald.conf.d
for generator in /root/lib/systemd/system-generators/*; do
  ln -s /dev/null "/root/run/systemd/system-generators/${generator##*/}"
done
printf '[Journal]\nStorage=volatile\nRateLimitBurst=0\n' >/root/run/systemd/journald.conf.d/lab.conf

# With a known machine id, systemd does not treat this as the first boot, which would enable
# everything.
echo 0123456789abcdef0123456789abcdef >/root/etc/machine-id

# A host that is a container has a marker file, which this machine must not have.
rm -f /root/.dockerenv

# If the host's user is not root, these files cannot be read: replace them with empty ones.
for file in /root/etc/shadow /root/etc/gshadow; do
  cat $file >/dev/null 2>&1 || { rm -f $file; touch $file; chmod 640 $file; }
done

# Only the bus devices are needed.
mkdir $units/systemd-udev-trigger.service.d
cat >$units/systemd-udev-trigger.service.d/lab.conf <<end
[Service]
ExecStart=
ExecStart=-udevadm trigger --action=add --subsystem-match=net
end

# Packet filters of units make the kernel patch its code, too (see guest-init.sh), for the
# first unit and the last. So one unit always has a filter.
mkdir $units/system.slice.d
printf '[Slice]\nIPAddressDeny=192.0.2.1\n' >$units/system.slice.d/lab.conf

cat >$units/lab.service <<end
[Unit]
Description=What the lab was asked to run
Requires=basic.target
After=basic.target

[Service]
NotifyAccess=all
Environment=HOME=/root LANG=C.UTF-8
ExecStart=/bin/sh /run/lab-job
ExecStopPost=/bin/systemctl reboot --force --force
end

exec switch_root /root /lib/systemd/systemd --unit=lab.service --log-target=console
