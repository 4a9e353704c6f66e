#!/bin/bash
# doctor finds nothing to fix in a private network, and names the missing route in one without.
. "$(dirname "$0")/common.sh"

"$bin/doctor" >"$scratch/fine.log" || fail "doctor sees $? things to fix in a network where the set runs"
grep -q '^ok   multicast route *through lo$' "$scratch/fine.log" || fail "the route of this network was not seen"

status=0
unshare -n "$bin/doctor" >"$scratch/bare.log" 2>/dev/null || status=$?
[ $status -eq 3 ] || fail "exit status $status without a network: loopback, route and LCM are three things to fix"
grep -q '^FIX  loopback .*ip link set lo up' "$scratch/bare.log" || fail "no cure for the loopback"
grep -q '^FIX  multicast route .*launch/multicast-route' "$scratch/bare.log" || fail "no cure for the route"

unshare -n "$bin/doctor" --json 2>/dev/null >"$scratch/bare.json" || true
check_report "$scratch/bare.json" '[f["verdict"] for f in r if f["what"] == "multicast route"] == ["fix"]'
"$bin/doctor" --channels | grep -q '^| FRAME | frame_t |' || fail "no table of channels"
