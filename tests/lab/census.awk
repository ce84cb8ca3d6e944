# Compares the system calls of one thread, as recorded by strace, with those allowed to the beat: in
# each tick at most one receive of many frames per bus, eight receives per camera connection, one
# wake of one thread, and the sleep until an absolute time. None of them may block.
#
#   awk -v buses=N -v cameras=N [-v clock_is_a_call=1] -f census.awk TRACE
#
# Prints the counts; exit status 1 if there was any other call. Calls before the first sleep and
# after the last belong to the thread's start and end. `clock_is_a_call`: on this machine, reading
# the clock is a system call (no vDSO for its clock source).
function wrong(why) {
  if (problems++ < 5) print "line " NR ": " why ": " $0
}

function allow(name, most) {
  if (in_tick[name] > most) wrong(name " " in_tick[name] " times in a tick, not " most)
  delete in_tick[name]
}

# A tick ends when the thread goes to sleep.
function end_tick(name) {
  allow("recvmmsg", buses)
  allow("recvmsg", 8 * cameras)
  allow("futex", 1)
  if (clock_is_a_call) delete in_tick["clock_gettime"]
  for (name in in_tick) wrong("not the beat's: " name)
  split("", in_tick)
  if (pending != "") wrong(pending)
  pending = ""
  ++ticks
}

!/^[a-z_0-9]+\(/ {next}

{
  name = substr($0, 1, index($0, "(") - 1)
  if (name == "clock_nanosleep") {
    if (begun) end_tick()
    if ($0 !~ /^clock_nanosleep\(CLOCK_MONOTONIC, TIMER_ABSTIME, /) wrong("not an absolute sleep")
    split("", in_tick)
    for (seen in since) total[seen] += since[seen]
    split("", since)
    begun = 1
    next
  }
  if (!begun) next
  ++in_tick[name]
  ++since[name]
  if (name ~ /^recvm/ && !/MSG_DONTWAIT/) pending = "a receive that may block"
  if (name == "futex" && !/FUTEX_WAKE_PRIVATE, 1(\)|,)/) pending = "a futex that is no wake of one thread"
}

END {
  printf "%d ticks:", ticks
  for (name in total) printf " %s %d", name, total[name]
  print ""
  if (ticks < 100) {
    print "too few ticks: nothing was shown"
    problems++
  }
  if (total["futex"] < ticks * 0.9) {
    print "hardly a wake: this is not the beat"
    problems++
  }
  exit problems > 0
}
