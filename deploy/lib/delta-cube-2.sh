# Chapter 2 of the published study: the predecessors' Delta Cube 2, measured in three configurations. Sourced by demo.sh.

source "$root/deploy/lib/set_ups.sh"

default_speed=300
ask_words='driftwise model grow joined.csv --together line'

formula='q ~ poly(x, y, z, 3)'

# at_control LINE: a line at the control port of the simulated cell; its answer without OK
at_control() {
  local address answer; address=$(sed -n 's/.*"control":"\([^"]*\)".*/\1/p' "$out/cellsim.out")
  exec 4<>"/dev/tcp/${address%:*}/${address##*:}"
  echo "$1" >&4
  read -r answer <&4
  exec 4>&-
  [[ $answer == OK* ]] || { echo "$answer"; return 1; }
}

# open_box SECONDS: a person opens the box for so long and carries the instruments to their next places
open_box() {
  local answer; answer=$(at_control "open $1 s") || die "the box does not open: $answer"
}

# rest HOURS SETUP: the box stabilises for so long. At once and without a daemon, whose waits would keep to its speed, but for the last
# half hour: one row at zero, with the temperatures on record. Counts run up.
rest() {
  local answer hours=$1
  end_daemon
  for _ in $(seq 50); do  # the cell may see the daemon's connections a moment longer
    answer=$(at_control "pass $(awk -v h="$hours" 'BEGIN { print 3600 * h - 1800 }') s") && break
    sleep 0.1
  done
  [ -z "$answer" ] || die "the hours do not pass: $answer"
  begin_daemon
  printf 'q1_mm,q2_mm,q3_mm,set,line,zero,dwell_s\n0,0,0,calibration,1,1,1800\n' >"$out/rest.plan.csv"
  driftwise run start "$out/rest.plan.csv" --setup "$2" --name "stabilisation before $2" --watch >"$out/rest-$2.txt"
  run=$((run + 1))
}

# session NUMBER: configuration NUMBER, exported as configuration-NUMBER.csv; its run is appended to `sessions`
session() {
  session_in "configuration-$1" "configuration-$1"
  sessions+=("$run")
}
session_in() {  # session_in SETUP NAME: exported as NAME.csv
  driftwise run start "$cell/trajectories/shortened.csv" --setup "$1" --name "$2" --watch >"$out/$2.txt"
  run=$((run + 1))
  driftwise data export $run -o "$out/$2.csv"
}

# full_plan: hours of the predecessors' 19^3 poses by the daemon's own estimator
full_plan() {
  driftwise trajectory grid --axes q1,q2,q3 --block 'calibration -1.8:1.8:0.2' -o "$out/full.csv"
  driftwise trajectory check "$out/full.csv" --json >"$out/full.json" || true
  driftwise trajectory check "$out/full.csv" | sed -n 1,12p
  cat <<TXT
  published: 6859 poses at 15 s = 28 h, three times with 9.5 h of opening and stabilisation: 112.5 h. Estimated, not measured: three
  times the duration above and 3 x 9.5 h. Measured here: the shortened plan, 7^3 and 4^3 between them.
TXT
}

demo() {
  local run=0 sessions=()
  say "the simulated cell and the daemon, speed $speed, seed $seed; the box has stood closed for twelve hours"
  start_cell delta-cube-2 "$speed" "$seed" ${cellsim_options:-}
  driftwise status

  say "the full plan, 19^3 poses: estimated"
  full_plan

  say "configuration 1: x, ry, rz"
  session 1
  say "the box is opened for half an hour, then nine hours of stabilisation, the last half hour on record; configuration 2: y, rx, ry"
  open_box 1800; rest 9.5 configuration-2; session 2
  say "the box is opened again; configuration 3: z"
  open_box 1800; rest 9.5 configuration-3; session 3

  say "the three sessions joined by row"
  driftwise data join "${sessions[@]}" --name joined --json >"$out/join.json"
  run=$((run + 1))
  driftwise data join "${sessions[@]}" --dry-run
  driftwise data export $run -o "$out/joined.csv"
  report delta-cube-2 join "$out"

  say "a wrong join is refused: configurations 1 and 2 with the rows of one shifted"
  awk -F, 'BEGIN { OFS = FS } /^#/ { print; next } !n { n = split($0, name); for (i = 1; i <= n; i++) if (name[i] ~ /^(y_mm|rx_arcsec|ry_arcsec)$/) moved[i] = 1; else if (name[i] == "passage") beside = i; print; next }
    beside && $beside == 1 { print; next }
    { for (i in moved) { keep = $i; $i = (i in last) ? last[i] : $i; last[i] = keep } print }' "$out/configuration-2.csv" >"$out/shifted.csv"
  driftwise data join "$out/configuration-1.csv" "$out/shifted.csv" "$out/configuration-3.csv" --correction "$out/cell.toml" -o "$out/wrong.csv" &&
    die "the shifted rows were joined" || true

  say "model-based and model-free on the same rows"
  driftwise model compare "$out/joined.csv" --kinematics "$out/cell.toml" --model "$formula" --methods nominal,kinematic,classic,stepwise --json >"$out/methods.json"
  driftwise model compare "$out/at_truth.csv" --kinematics "$out/cell.toml" --model "$formula" --methods nominal,kinematic,classic,stepwise --json >"$out/methods_truth.json"
  report delta-cube-2 methods "$out"

  say "which terms, and how many points"
  driftwise model grow "$out/joined.csv" --together line
  driftwise model points "$out/joined.csv" --model "$formula" --together line

  say "other ways to identify the same model, on the same rows"
  install_missing compare
  /usr/bin/python3 "$root/deploy/lib/other_methods.py" "$out/joined.csv" "$out/at_truth.csv"
  closing_words "join.json  the join;   methods.json  model-based and model-free"
}
