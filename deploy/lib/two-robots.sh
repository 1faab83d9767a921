# Case C.2 of the published study: two robots that touch. Both are calibrated, a plan serves, indentation by it. Sourced by demo.sh.

source "$root/deploy/lib/set_ups.sh"

default_speed=200                        # of the calibration
contact_speed=20                         # of the contacts: a look is half a second of cell time
prefix=ma.
ask_words='driftwise plan target mn.x=1 mn.y=0.5 mn.z=0.2 ma.rx=100 ma.ry=0 ma.z=1'
fine='ma.q ~ poly(ma.rx, ma.ry, ma.z, 3)'

# control LINE: the simulated cell's private port, one answer without its OK
control() {
  local address answer
  address=$(sed -n 's/^READY .*"control": *"\([^"]*\)".*/\1/p' "$out/cellsim.out")
  exec 3<>"/dev/tcp/${address%:*}/${address##*:}"
  echo "$1" >&3
  read -r answer <&3
  exec 3>&-
  case "$answer" in OK*) echo "${answer#OK }" ;; *) die "control port, $1: $answer" ;; esac
}

# truth COLUMN: what really is, now
truth() { control 'truth?' | sed -n "s/.*\"$1\":\([^,}]*\).*/\1/p"; }

# microscope CONTACT: the craters from this contact on, as CSV
microscope() {
  echo 'id,x_um,y_um,pixel_nm,marking_px,pictures_joined,diagonal_um'
  control "microscope? $1" | sed 's/},{/\n/g; s/[][{}"]//g; s/[a-z_]*://g'
}

# of_robot ROBOT: a trajectory of q1_mm .. on standard input, with the robot's id
of_robot() { sed "s/^q1_mm,q2_mm,q3_mm/$1.q1_mm,$1.q2_mm,$1.q3_mm/"; }

# fine_rows: poses rx, ry (arcsec), z (mm) as motor coordinates of nominal geometry: 125 to be fitted, 64 between them
fine_rows() {
  awk 'function q(rx, ry, z, azimuth) { return z + 60 * (sin(azimuth) * rx - cos(azimuth) * ry) * 4.84813681e-6 }
    function row(rx, ry, z, set) { printf "%.5f,%.5f,%.5f,%s,%d,0\n", q(rx, ry, z, 0), q(rx, ry, z, 2.0943951), q(rx, ry, z, 4.1887902), set, line }
    BEGIN {
      print "# driftwise-trajectory: 1\nma.q1_mm,ma.q2_mm,ma.q3_mm,set,line,zero\n0,0,0,calibration,0,1"
      for (z = -3.04; z < 3.1; z += 1.52) {
        line++
        for (rx = -310; rx <= 310; rx += 155) for (ry = -310; ry <= 310; ry += 155) row(rx, ry, z, "calibration")
        print "0,0,0,calibration," line ",1"
      }
      for (z = -2.25; z < 2.3; z += 1.5) {
        line++
        for (rx = -225; rx <= 225; rx += 150) for (ry = -225; ry <= 225; ry += 150) row(rx, ry, z, "validation")
        print "0,0,0,validation," line ",1"
      }
    }'
}

calibrate_below() {
  local probe_run tilt_run shared=$root/deploy/cells/min-angle/trajectories
  say "the MinAngle, rectification: the vertical path by the interferometer and by the touch probe, 17 heights"
  of_robot ma <"$shared/height.csv" >height.plan.csv
  rectification height.plan.csv
  cp cell.toml uncorrected.toml
  cat "$cell/correction.toml" >>cell.toml  # from here on lengths are corrected by the tilts
  restart_with_scale
  say "the MinAngle, large stroke: 125 positions and 8 checks, height by the probe, tilts by the inclinometer"
  of_robot ma <"$shared/large.csv" >large.plan.csv
  in_two_passes large large.plan.csv level
  joined large $probe_run $tilt_run
  fitted model1 $run "$fine"
  say "the MinAngle, fine: 125 poses within 310 arcsec and 3 mm, 64 between them"
  fine_rows >fine.plan.csv
  in_two_passes fine fine.plan.csv collimators
  joined fine $probe_run $tilt_run
  fitted model2 $run "$fine"
  say "the MinAngle, sideways: 17 heights up and down, five times"
  head -n 163 "$shared/parasitic.csv" | of_robot ma >sideways.plan.csv
  measured sideways sideways.plan.csv sideways
  fitted sideways-x $run 'ma.x ~ ma.z + ma.z^2 + ma.z^3 + t19'
  fitted sideways-y $run 'ma.y ~ ma.z + ma.z^2 + ma.z^3 + t19'
}

calibrate_above() {
  say "the Micro-Nano: 125 positions twice, 64 between them, with its tilts"
  driftwise trajectory grid --axes q1,q2,q3 --block 'calibration -0.5:2.5:0.75' --block 'validation -0.125:2.125:0.75' \
    --block 'calibration -0.5:2.5:0.75' -o tool.grid.csv
  of_robot mn <tool.grid.csv >tool.plan.csv
  measured tool tool.plan.csv tool
  fitted tool-model $run 'mn.q ~ poly(mn.x, mn.y, mn.z, 3) + t04..t10'
  local tilt
  for tilt in rx ry rz; do fitted tool-$tilt $run "mn.$tilt ~ poly(mn.x, mn.y, mn.z, 3)"; done
}

# serving_plan: the tool follows the substrate. The tilts of the tool are not given to the substrate: it turns about a centre of its
# own, which would add error (chapter 8).
serving_plan() {
  cat >plan.toml <<PLAN
name = "indenter over substrate"

[[robot]]
id = "mn"
model = $(model tool-model)

[[robot]]
id = "ma"

[[blend]]
robot = "ma"
$(soft_switch_bands)

[[parasitic]]
model = $(model sideways-x)
from = "ma"
to = "mn"
add = ["x_mm"]

[[parasitic]]
model = $(model sideways-y)
from = "ma"
to = "mn"
add = ["y_mm"]

[z]
taken_by = "mn"
rest_mm = 0
PLAN
  driftwise plan check plan.toml
  driftwise plan add plan.toml
  driftwise plan promote 1 --yes
}

# online: 40 new positions of the tool in the work plane and about it, by the plan and by nominal geometry. line: the position
online() {
  awk -v seed="$seed" 'BEGIN {
    srand(seed); print "x_mm,y_mm,z_mm"
    for (i = 0; i < 40; i++) printf "%.4f,%.4f,%.4f\n", 2 * rand() - 1, 2 * rand() - 1, 0.6 + 0.8 * rand()
  }' >wanted.csv
  awk -F, 'BEGIN { print "# driftwise-trajectory: 1\nmn.x_mm,mn.y_mm,mn.z_mm,ma.rx_arcsec,ma.ry_arcsec,ma.z_mm,set,line,zero" }
    NR > 1 { printf "%s,%s,%s,0,0,0,validation,%d,0\n", $1, $2, $3, NR - 1 }' wanted.csv >by_plan.plan.csv
  awk -F, 'function q(x, y, z, azimuth) {
      return z + sqrt(70 ^ 2 - (x - 44.8 * cos(azimuth)) ^ 2 - (y - 44.8 * sin(azimuth)) ^ 2) - sqrt(70 ^ 2 - 44.8 ^ 2) }
    BEGIN { print "# driftwise-trajectory: 1\nmn.q1_mm,mn.q2_mm,mn.q3_mm,set,line,zero" }
    NR > 1 { printf "%.6f,%.6f,%.6f,validation,%d,0\n", q($1, $2, $3, 0), q($1, $2, $3, 2.0943951), q($1, $2, $3, 4.1887902), NR - 1 }' \
    wanted.csv >by_geometry.plan.csv
  measured by_plan by_plan.plan.csv tool --compensate
  driftwise run verify $run --json >by_plan.verify.json
  measured by_geometry by_geometry.plan.csv tool
}

# calibrated_and_served: with spacers between the robots, for the MinAngle's stroke is longer than the gap
calibrated_and_served() {
  control 'spacers 14 mm' >/dev/null
  calibrate_below
  calibrate_above
  say "the serving plan: checked, promoted"
  serving_plan
  say "40 new positions of the tool, by the plan and by nominal geometry"
  online
  report two-robots tables "$out"
  say "the spacers are taken out; cell time at speed $contact_speed"
  driftwise home
  control 'spacers 0 mm' >/dev/null
  sed "s/^speed = .*/speed = $contact_speed/; /^device = \"touch\"/,/^min/ s/^scale = 1.0 /scale = $(cat scale.txt) /" uncorrected.toml >cell.toml
  restart_daemon
  driftwise configuration accept --yes --note "contacts: the lengths are watched live, without correction" || true
}

# watched: the set-up of the last run stays in use, so that during the contacts the Micro-Nano's instruments are read, and no others
watched() {
  printf '# driftwise-trajectory: 1\nmn.q1_mm,mn.q2_mm,mn.q3_mm,set,line,zero\n0,0,0,validation,1,1\n1,1,1,validation,2,0\n' >watched.plan.csv
  measured watched watched.plan.csv tool
}

# state_of KEY FILE: a number or a text of the procedure's record
state_of() { sed -n 's/^ *"'"$1"'": *"\{0,1\}\([^"]*[^",]\)"\{0,1\},\{0,1\}$/\1/p' "$2" | head -n 1; }

# aligned_substrates COUNT: a fresh substrate each time, tilted by random up to 0.5 degrees: touched, aligned, common zero, one indent, by
# the plan. The first finds the height, the others depart 30 um below it.
aligned_substrates() {
  local i tilt state corrections depart=1.555
  rm -f substrate*
  for i in $(seq "$1"); do
    tilt=$(awk -v seed=$((seed * 1000 + i)) 'BEGIN { srand(seed); rand(); printf "%.0f %.0f", 3600 * rand() - 1800, 3600 * rand() - 1800 }')
    control "substrate $tilt arcsec" >/dev/null
    sed "s/^closed_loop_\([xy]\)_um = .*/closed_loop_\1_um = []/; s/^x_um = .*/x_um = [250]/; s/^y_um = .*/y_um = []/
         s/^depart_mm = .*/depart_mm = $depart/" indentation.toml >"substrate.$i.toml"
    driftwise indent start "substrate.$i.toml" >"substrate.$i.txt" 2>&1 || tail -n 1 "substrate.$i.txt"
    state=substrate.$i.toml.state.json
    [ -s "$state" ] || { echo "$i: substrate $tilt arcsec: nothing was begun"; continue; }
    corrections=$(state_of corrections "$state")
    depart=$(state_of height_mm "$state" | awk '{ printf "%.4f", $1 - 0.03 }')
    echo "$i: substrate $tilt arcsec, stage $(state_of stage "$state"), $corrections corrections, contacts agree to $(state_of spread_nm "$state") nm, by $(state_of by "$state")"
  done | tee substrates.txt
  awk -v of="$1" '/stage (zero|indents|microscope), [0-3] corrections/ && /ma=(coarse|fine|blend):/ { n++ }
    END { printf "aligned to 500 nm in at most 3 corrections, the record says which model answered: %d of %d\n", n, of }' substrates.txt
}

demo() {
  local zero status=0 run=0
  [ $by = plan ] || speed=$contact_speed
  say "the simulated cell and the daemon, speed $speed, seed $seed"
  start_cell two-robots "$speed" "$seed" ${cellsim_options:-}
  cp "$cell/indentation.toml" "$cell/table_8_1.csv" "$out/"
  if [ $by = plan ]; then
    calibrated_and_served
  else
    sed -i 's/^by = .*/by = "geometry"\nreason = "asked for: deploy\/demo.sh indentation --by-geometry"/' indentation.toml
  fi
  watched
  if [ "$substrates" -gt 0 ]; then
    say "$substrates substrates, each aligned by what the plan serves"
    aligned_substrates "$substrates"
    return
  fi
  say "indentation: touch, align, common zero, 10 indents"
  driftwise indent start indentation.toml 2>&1 | tee indentation.txt
  say "the microscope's table onto the indents"
  zero=$(sed -n 's/.*the first is contact \([0-9]*\)\..*/\1/p' indentation.txt)
  microscope "$zero" >microscope.csv
  driftwise indent import indentation.toml microscope.csv -o indents.csv || status=$?
  [ $status -le 1 ] || die "the import ended with exit code $status"
  driftwise indent import indentation.toml microscope.csv --json >indents.json || true
  say "the published table 8.1 through the same command"
  driftwise indent table table_8_1.csv --wanted 0.2 || true
  say "the truth of the simulated cell, which nothing above was told"
  cat <<TXT
tool lever             $(truth lever_mm | awk '{ printf "%.2f", $1 }') mm; stated 100
microscope scale       x +2 %, y +0.4 %
table                  $(sed -n 's/.*"indistinguishable":\(\[[^]]*\]\).*/\1/p' indents.json): the set named
TXT
  report two-robots contacts "$out"
  say "done. Everything is in $out"
  cat <<TXT
  indents.csv           the table;   microscope.csv  as the simulated microscope gave it
  indentation.toml.state.json  the record of the procedure;   truth.csv  where tool and substrate really were
  logs                  driftwised.log, cellsim.log
TXT
}
