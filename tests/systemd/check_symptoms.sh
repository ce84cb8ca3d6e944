#!/bin/bash
# The symptoms in docs/operations.md are what odomd and odom say, word for word: every line below
# stands in the page and in the sources (where a name or a number is filled in, the words around it).
#   check_symptoms.sh SOURCE_DIR
set -eu
cd "$1"
sources=$(find base daemon can_protocol tools -name '*.[ch]pp' -exec cat {} +; cat shm_api/libodom/*.c)
page=$(cat docs/operations.md)
# As the compiler sees it: adjacent literals are one.
sources=$(find base daemon can_protocol tools -name '*.[ch]pp' -exec cat {} +; cat shm_api/libodom/*.c)

status=0
while IFS= read -r words; do
  [[ $page == *"$words"* ]] || { echo "not in the page: $words"; status=1; }
  [[ $sources == *"$words"* ]] || { echo "nobody says: $words"; status=1; }
done <<'end'
no such segment: is odomd running?
segment refused: untrusted owner, writable by others, or not readable
not allowed; join the group of the socket (the service's: odom)
stale: odomd has not ticked for four periods
no such socket
cannot be read: 
: there is no such interface; it is waited for
: the bus is down; bring it up: ip link set 
 was never received: is it on the bus, and is the database right?
 fails its protection: look at the status
 is overdue: the last one is 
 is not scheduled in real time (SCHED_FIFO 
CPUs may sleep deeply: 
; give access to the device
: the receive buffer is 
; raise net.core.rmem_max, or grant CAP_NET_ADMIN
ticks missed: 
; the beat woke 
end
exit $status
