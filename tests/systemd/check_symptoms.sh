#!/bin/bash
# The symptoms in docs/operations.md are real messages of odomd and odom: each line below occurs in
# the page and in the sources (only the text around names and numbers is compared).
#   check_symptoms.sh SOURCE_DIR
set -eu
cd "$1"
sources=$(find base daemon can_protocol tools -name '*.[ch]pp' -exec cat {} +; cat shm_api/libodom/*.c)
page=$(cat docs/operations.md)
# Joins adjacent string literals, as the compiler does.
sources=$(perl -0pe 's/"\s*\n\s*"//g' <<<"$sources")

status=0
while IFS= read -r words; do
  [[ $page == *"$words"* ]] || { echo "not in the page: $words"; status=1; }
  [[ $sources == *"$words"* ]] || { echo "not in the sources: $words"; status=1; }
done <<'end'
segment refused: untrusted owner, writable by others, or not readable
not allowed; join the group 
of the socket (the service's: odom)
no such socket
cannot be read: 
was never received
fails its end-to-end protection
 is overdue: the last sample is 
 has no real-time scheduling (SCHED_FIFO 
CPUs may enter deep sleep: 
; grant access to the device
: the receive buffer is 
; raise net.core.rmem_max, or grant CAP_NET_ADMIN
ticks missed: 
; wake-up latency 
end
exit $status
