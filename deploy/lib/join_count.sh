#!/usr/bin/env bash
# Joined sessions of the Delta Cube 2 against the plant's truth, on the wire: of each seed, another machine, the demo's three sessions with
# the box opened between, joined; then a session that measures all six coordinates at once. The table: deploy/lib/join_count.py.
# Usage: deploy/lib/join_count.sh [FIRST_SEED [COUNT]]    (1, 5; of a built tree; DRIFTWISE_BUILD as for deploy/demo.sh)
# A seed that is there is not run again: a stopped series continues. Its sessions and figures: out/join-count/SEED
source "$(dirname "$0")/common.sh"

robot=delta-cube-2 first=${1:-1} count=${2:-5}
source "$root/deploy/lib/cell.sh"
source "$root/deploy/lib/delta-cube-2.sh"
speed=$default_speed
kept=$root/out/join-count
need_programs

# at_once: a set-up of all instruments, which only a simulated cell has in every place. ry is read by both autocollimators.
at_once() {
  cat >>"$out/cell.toml" <<'SETUP'

[[setup]]
name = "at-once"
description = "all six coordinates"

[[setup.confirmation]]
channel = "ry_arcsec"
device = "collimator-2"
limit = 5
SETUP
  local channel device
  while read -r channel device; do
    printf '\n[[setup.coordinate]]\nchannel = "%s"\ndevice = "%s"\n' "$channel" "$device" >>"$out/cell.toml"
  done <<'COORDINATES'
x_mm laser-x
y_mm laser-y
z_mm laser-z
rx_arcsec collimator-2
ry_arcsec collimator-1
rz_arcsec collimator-1
COORDINATES
  restart_daemon
  driftwise configuration accept --yes --note "a set-up of all instruments"
}

one_seed() {  # one_seed SEED: its sessions, and join_truth.json
  local run=0 sessions=()
  start_cell delta-cube-2 "$speed" "$1"
  at_once
  session 1
  open_box 1800; rest 9.5 configuration-2; session 2
  open_box 1800; rest 9.5 configuration-3; session 3
  driftwise data join "${sessions[@]}" --name joined --json >"$out/join.json"
  run=$((run + 1))
  driftwise data export $run -o "$out/joined.csv"
  session_in at-once at_once
  report delta-cube-2 join "$out"
  finish; daemon= cellsim=
  rm -f "$out"/driftwise.sqlite*
}

for seed in $(seq "$first" $((first + count - 1))); do
  [ -s "$kept/$seed/join_truth.json" ] && continue
  say "seed $seed, load $(cut -d' ' -f1-3 /proc/loadavg)"
  instance=join-count/$seed one_seed "$seed"
done
"$root/deploy/lib/join_count.py" $(seq -f "$kept/%g/join_truth.json" "$first" $((first + count - 1)))
