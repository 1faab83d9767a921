# Shared by the demos of cells with set-ups: runs, joins, the touch probe rectified. Sourced after cell.sh.

# of_plan FILE: a dataset without its rows `passage`: places beside the plan, which are no points (docs/formats.md)
of_plan() {
  awk -F, '/^#/ { print; next } !head { head = 1; for (i = 1; i <= NF; i++) if ($i == "passage") at = i; print; next }
    !(at && $at == 1)' "$1"
}

# column NAME FILE: values of a column of a dataset, one a line
column() { of_plan "$2" | awk -F, -v name="$1" '/^#/ { next } !at { for (i = 1; i <= NF; i++) if ($i == name) at = i; next } { print $at }'; }

# measured NAME TRAJECTORY SETUP [options of run start]: a run, exported as NAME.csv. Sets run to its number.
measured() {
  driftwise run start "$2" --setup "$3" --name "$1" --watch "${@:4}" >"$out/$1.txt"
  run=$((run + 1))
  driftwise data export $run -o "$out/$1.csv"
}

# joined NAME RUN RUN: both passes as one run, exported as NAME.csv. Sets run to its number.
joined() {
  driftwise data join "$2" "$3" --name "$1" --json >"$out/$1.join.json"
  run=$((run + 1))
  driftwise data export $run -o "$out/$1.csv"
}

# in_two_passes NAME TRAJECTORY TILTS: height by the probe, tilts by TILTS. Sets probe_run and tilt_run.
in_two_passes() {
  measured "$1_z" "$2" probe; probe_run=$run
  measured "$1_tilts" "$2" "$3"; tilt_run=$run
}

# fitted NAME RUN FORMULA: a model of a run
fitted() { driftwise fit --run "$2" --json --model "$3" --name "$1" >"$out/$1.json"; }

# soft_switch_bands: of a plan's [[blend]]: model 2 within 300 arcsec and 2.9 mm, model 1 from 350 arcsec and 3 mm
soft_switch_bands() {
  cat <<BANDS
fine = $(model model2)
coarse = $(model model1)
anchored = true
[[blend.band]]
coordinates = ["rx_arcsec", "ry_arcsec"]
from = 300
to = 350
fade_to = 1500
[[blend.band]]
coordinates = ["z_mm"]
from = 2.9
to = 3.0
fade_to = 3.6
BANDS
}

# promoted NAME RUN FORMULA: ... in service
promoted() {
  fitted "$@"
  driftwise model promote "$(model "$1")" --yes
}

# by_row COLUMN FILE: "line and commanded coordinates,value" of every point, sorted: a row that was visited again stands elsewhere in the file
by_row() {
  of_plan "$2" | grep -v '^#' | awk -F, -v wanted="$1" '
    NR == 1 { for (i = 1; i <= NF; ++i) { if ($i == wanted) value = i; if ($i == "line" || $i ~ /_cmd_mm$/) key[i] } next }
    { row = ""; for (i = 1; i <= NF; ++i) if (i in key) row = row $i ";"; print row "," $value }' | LC_ALL=C sort
}

# rectification TRAJECTORY: what the probe reads against the interferometer, on the path that both measured: z = k z_probe + c.
# prefix: of a robot among several ("ma.").
rectification() {
  local z=${prefix:-}z_mm
  measured height "$1" height
  measured touch "$1" probe
  {
    echo 'z_mm,touch_mm'
    LC_ALL=C join -t, <(by_row $z "$out/height.csv") <(by_row $z "$out/touch.csv") | cut -d, -f2,3
  } >"$out/rectification.csv"
  [ "$(column $z "$out/height.csv" | wc -l)" = "$(tail -n +2 "$out/rectification.csv" | wc -l)" ] || die "a point of the vertical path is missing"
  driftwise fit "$out/rectification.csv" --model 'z ~ touch' --select all --json >"$out/rectification.json"
  report min-angle rectification "$out"
}

# restart_daemon: ended and started again, with the cell file as it is now
restart_daemon() { end_daemon; begin_daemon; }
end_daemon() {
  kill -TERM "$daemon"; wait "$daemon" || true
  daemon=
}
begin_daemon() {
  rm -f "$out/driftwised.json"
  "$bin/driftwised" --cell "$out/cell.toml" >"$out/driftwised.out" 2>>"$out/driftwised.log" & daemon=$!
  wait_for "$out/driftwised.json" "$daemon" driftwised
}

# restart_with_scale: the rectified scale into the set-up, and a daemon that reads it
restart_with_scale() {
  local scale; scale=$(cat "$out/scale.txt")
  sed -i "/^device = \"touch\"/,/^min/ s/^scale = 1.0 /scale = $scale /" "$out/cell.toml"
  grep -q "^scale = $scale" "$out/cell.toml" || die "the set-up 'probe' has no scale in $out/cell.toml"
  restart_daemon
  driftwise configuration accept --yes --note "probe rectified to the interferometer, $(sha256sum <"$out/rectification.csv" | cut -c1-12)"
}
