#!/bin/bash
# What becomes of the recording when something happens to its recorder.
. "$(dirname "$0")/common.sh"

film 30

echo "one that was killed and came back leaves one recording"
start run "$top/run" --images "$scratch/film" --rate 5 --report "$scratch/report"
recording="$scratch/report/recording.lcm"
for ((i = 0; i < 400; ++i)); do
  if [ "$(stat -c %s "$recording" 2>/dev/null || echo 0)" -gt 4000000 ]; then break; fi  # the fifth frame
  sleep 0.05
done
kill -KILL "$(cat "$scratch/report/services/record/supervise/pid")"
wait "${pid_of[run]}" || true  # the event at which it was cut is damage
[ ! -e "$scratch/report/recording.1.lcm" ] || fail "it is in pieces"
check_report "$scratch/report/report.json" '15 <= r["frames"] <= 30'
grep -q "The recorder died and came back" "$scratch/run.log" || fail "nobody was told"

[ -z "${STEVEDORE_SANITIZE:-}" ] || exit 0 # a sanitizer must be the first library
echo "one during which the wall clock is set keeps its time"
cat >"$scratch/clock.cpp" <<'END'
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
// Sets the wall clock an hour back in the third second of a process.
extern "C" int clock_gettime(clockid_t clock, timespec* now) {
  timespec used{};
  syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &used);
  static const time_t start_s = used.tv_sec;
  const long status = syscall(SYS_clock_gettime, clock, now);
  if (clock == CLOCK_REALTIME && used.tv_sec - start_s >= 2) now->tv_sec -= 3600;
  return static_cast<int>(status);
}
END
g++ -shared -fPIC "$scratch/clock.cpp" -o "$scratch/clock.so"
start record env LD_PRELOAD="$scratch/clock.so" "$bin/record" --out "$scratch/clock.lcm"
wait_log record running
sleep 5
stop record
python3 - "$scratch/clock.lcm" <<'END'
import struct, sys
log, times = open(sys.argv[1], "rb").read(), []
while log:  # sync word, number, time, lengths of channel and data
    _, _, time_us, channel, data = struct.unpack(">IQqii", log[:28])
    times.append(time_us)
    log = log[28 + channel + data:]
assert len(times) >= 3 and times == sorted(times) and times[-1] - times[0] < 60e6, times
END
