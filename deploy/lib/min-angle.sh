# Case C.1 of the published study: the MinAngle, two tilts and a height, measured in set-ups. Sourced by demo.sh.

source "$root/deploy/lib/set_ups.sh"

default_speed=200
ask_words='driftwise plan target rx=100 ry=0 z=1'
large='q ~ poly(rx, ry, z, 3)'

# grid SET TILTS HEIGHTS: poses rx, ry (arcsec), z (mm), tilts fastest as the study's lines, a return to zero after each height
grid() {
  local rx ry z line=0
  for z in $3; do
    for rx in $2; do for ry in $2; do echo "$rx $ry $z $1 $line 0"; done; line=$((line + 1)); done
    echo "0 0 0 $1 $line 1"; line=$((line + 1))
  done
}

# targets NAME: poses on standard input become NAME.plan.csv (motor coordinates of the model in service, asked for on the text
# line) and NAME.wanted.csv (the same with the poses)
targets() {
  local address q answer rx ry z set line zero; address=$(sed -n 's/.*"target_line": *"\([^"]*\)".*/\1/p' "$out/driftwised.json")
  exec 3<>"/dev/tcp/${address%:*}/${address##*:}"
  printf '# driftwise-trajectory: 1\nq1_mm,q2_mm,q3_mm,set,line,zero\n0,0,0,calibration,0,1\n' >"$out/$1.plan.csv"
  echo 'q1_mm,q2_mm,q3_mm,rx_arcsec,ry_arcsec,z_mm' >"$out/$1.wanted.csv"
  while read -r rx ry z set line zero; do
    if [ "$zero" = 1 ]; then echo "0,0,0,$set,$line,1" >>"$out/$1.plan.csv"; continue; fi
    echo "TARGET rx_arcsec=$rx ry_arcsec=$ry z_mm=$z" >&3
    read -r answer <&3
    q=$(sed -n 's/^OK q1_mm=\([^ ]*\) q2_mm=\([^ ]*\) q3_mm=\([^ ]*\) .*/\1,\2,\3/p' <<<"$answer")
    [ -n "$q" ] || die "target rx_arcsec=$rx ry_arcsec=$ry z_mm=$z: $answer"
    echo "$q,$set,$line,0" >>"$out/$1.plan.csv"
    echo "$q,$rx,$ry,$z" >>"$out/$1.wanted.csv"
  done
  exec 3>&-
}

# coldest HOURS: one row at zero that waits until the story of the room is so old
coldest() {
  local epoch now dwell
  epoch=$(date -d "$(sed -n 's/^epoch = "\(.*\)"/\1/p' "$out/cell.toml")" +%s)
  now=$(date -d "$(driftwise status --json | sed -n 's/.*"cell_time":"\([^"]*\)".*/\1/p')" +%s)
  dwell=$(awk -v left="$1" -v gone=$((now - epoch)) 'BEGIN { s = left * 3600 - gone; print (s > 60 ? s : 60) }')
  printf 'q1_mm,q2_mm,q3_mm,set,line,zero,dwell_s\n0,0,0,calibration,1,1,%s\n' "$dwell" >"$out/cooling.plan.csv"
  driftwise run start "$out/cooling.plan.csv" --setup parasitic --name cooling --watch >"$out/cooling.txt"
  run=$((run + 1))
}

# soft_switch: model 2 within 300 arcsec and 2.9 mm, model 1 from 350 arcsec and 3 mm, blended between; checked, then asked
soft_switch() {
  local rx
  cat >"$out/plan.toml" <<PLAN
name = "large and fine"

[[robot]]

[[blend]]
$(soft_switch_bands)
PLAN
  driftwise plan check "$out/plan.toml"
  driftwise plan add "$out/plan.toml"
  driftwise plan promote 1 --yes
  for rx in 100 320 4000; do
    echo "target rx=$rx arcsec, ry=0, z=1 mm"
    driftwise plan target rx=$rx ry=0 z=1
  done
}

# ideal_probe: the fine poses again, by a cell whose probe has no hysteresis. In a subshell: its cell is its own.
ideal_probe() (
  local main=$out run=0 probe_run tilt_run
  cellsim= daemon=
  trap finish EXIT
  instance=min-angle-ideal
  start_cell min-angle "$speed" "$seed" --set touch_probe.friction_um=0
  in_two_passes fine "$main/fine.plan.csv" collimators
  joined fine $probe_run $tilt_run
  driftwise fit --run $run --json --model "$large" --name model2 >"$main/ideal/model2.json"
)

demo() {
  local ideal run=0 probe_run tilt_run
  say "the simulated cell and the daemon, speed $speed, seed $seed"
  start_cell min-angle "$speed" "$seed" ${cellsim_options:-}
  driftwise status

  say "rectification: the vertical path by the interferometer and by the touch probe, 17 heights"
  rectification "$cell/trajectories/height.csv"
  restart_with_scale

  say "large stroke: 125 positions and 8 checks, height by the probe, tilts by the inclinometer"
  in_two_passes large "$cell/trajectories/large.csv" level
  joined large $probe_run $tilt_run
  promoted model1 $run "$large"

  say "model 1 moves the robot: 25 tilts up to 3 degrees at height 0"
  grid validation '-10800 -5400 0 5400 10800' 0 | targets large_check
  in_two_passes large_check "$out/large_check.plan.csv" level

  say "fine: 343 poses within 300 arcsec and 3 mm, moved by model 1; 216 between them"
  { grid calibration '-300 -200 -100 0 100 200 300' '-3 -2 -1 0 1 2 3'
    grid validation '-250 -150 -50 50 150 250' '-2.5 -1.5 -0.5 0.5 1.5 2.5'; } | awk '{ $5 = NR; print }' | targets fine
  in_two_passes fine "$out/fine.plan.csv" collimators
  joined fine $probe_run $tilt_run
  promoted model2 $run "$large"

  say "model 2 moves the robot to the 216 poses"
  grid validation '-250 -150 -50 50 150 250' '-2.5 -1.5 -0.5 0.5 1.5 2.5' | targets fine_check
  in_two_passes fine_check "$out/fine_check.plan.csv" collimators

  say "soft switch: both models in one serving plan"
  soft_switch

  mkdir -p "$out/ideal"
  ideal_probe >"$out/ideal/cell.txt" 2>&1 & ideal=$!

  say "parasitic motion: the room is cooled, then 664 heights while it warms, five hours"
  coldest 7
  measured parasitic "$cell/trajectories/parasitic.csv" parasitic
  driftwise fit --run $run --json --model 'x ~ z + z^2 + z^3 + t09' --name parasitic-x >"$out/parasitic_x.json"
  driftwise fit --run $run --json --model 'y ~ z + z^2 + z^3 + t09' --name parasitic-y >"$out/parasitic_y.json"
  say "the same fine poses by a second cell with an ideal probe, measured meanwhile"
  wait "$ideal" || { tail -n 5 "$out/ideal/cell.txt" >&2; die "the cell with the ideal probe ended early"; }
  report min-angle tables "$out"
  closing_words "*.join.json  the joins;   *.wanted.csv  poses asked for"
}
