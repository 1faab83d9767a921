#!/usr/bin/env bash
# Case A of the published study from nothing to proof: installs what is missing, builds, lets the daemon measure the simulated linear axis over
# its real protocols, fits, validates, serves compensated targets, and moves to new positions while the air drifts. Safe to repeat.
# Usage: deploy/demo.sh [--speed CELL_SECONDS_PER_SECOND] [--seed N] [--no-build]
source "$(dirname "$0")/lib/common.sh"

speed=200 seed=1 build=yes
while [ $# -gt 0 ]; do
  case "$1" in
    --speed) speed=${2:?--speed needs a number}; shift 2 ;;
    --seed) seed=${2:?--seed needs a number}; shift 2 ;;
    --no-build) build=no; shift ;;
    *) die "unknown option '$1'; there are --speed, --seed and --no-build" ;;
  esac
done

if [ $build = yes ]; then
  say "packages"
  install_missing build
  say "build (preset release)"
  configure_and_build release -DDRIFTWISE_BUILD_TESTS=OFF
fi
bin=$root/build/release/bin
cell=$root/deploy/cells/linear-axis
out=$root/out/linear-axis
for program in driftwised driftwise driftwise-cellsim driftwise-demo-report; do
  [ -x "$bin/$program" ] || die "$bin/$program is not there: run deploy/demo.sh without --no-build"
done

cellsim= daemon=
finish() {
  # only what this script started, by pid
  [ -z "$daemon" ] || kill -TERM "$daemon" 2>/dev/null || true
  [ -z "$daemon" ] || wait "$daemon" 2>/dev/null || true
  [ -z "$cellsim" ] || kill -TERM "$cellsim" 2>/dev/null || true
  [ -z "$cellsim" ] || wait "$cellsim" 2>/dev/null || true
}
trap finish EXIT

wait_for() {  # wait_for FILE PID WHAT: until the file is there, for at most 30 s, or the process ends
  for _ in $(seq 300); do
    [ -s "$1" ] && return
    kill -0 "$2" 2>/dev/null || { tail -n 20 "$out"/*.log >&2; die "$3 ended before it was ready: its log is above, in $out"; }
    sleep 0.1
  done
  die "$3 was not ready within 30 s: see the logs in $out"
}
number_of() { sed -n "s/.*\"$1\":\([0-9]*\).*/\1/p" "$2"; }  # number_of KEY FILE, of one-line JSON

say "the simulated cell and the daemon, speed $speed, seed $seed"
rm -rf "$out"; mkdir -p "$out"; cd "$out"
"$bin/driftwise-cellsim" --plant "$cell/plant.toml" --cell "$cell/cell.toml" --instantiate "$out" --speed "$speed" --seed "$seed" \
  >"$out/cellsim.out" 2>"$out/cellsim.log" & cellsim=$!
wait_for "$out/cellsim.out" "$cellsim" driftwise-cellsim
"$bin/driftwised" --cell "$out/cell.toml" >"$out/driftwised.out" 2>"$out/driftwised.log" & daemon=$!
wait_for "$out/driftwised.json" "$daemon" driftwised
driftwise() { "$bin/driftwise" --operator demo "$@"; }   # finds the daemon by driftwised.json in this folder
driftwise status

say "the campaign: 18 positions 56 times, 1008 points of 4 readings, four hours of cell time"
driftwise run start "$cell/trajectories/published.csv" --name campaign --watch
driftwise data export 1 -o "$out/campaign.csv"

say "models: fitted by the daemon on its stored points"
fit() { driftwise fit --run 1 --json "${@:2}" --name "$1" >"$out/$1.json"; }
fit geometry --model 'q ~ x + x^2'
fit ten --model 'q ~ x + x^2 + T'
fit six --model 'q ~ x + x^2 + t05..t10'
fit first300 --model 'q ~ x + x^2 + T' --first 300
driftwise fit "$out/campaign.csv" --model 'q ~ x + x^2 + T' --offers --json >"$out/offers.json"
"$bin/driftwise-demo-report" fits "$out"

say "the same fit on the exported file, without the daemon"
strip() { sed -E 's/,"fit_us":[^,]*//; s/,"model_id":[0-9]*//' "$1"; }
driftwise fit "$out/campaign.csv" --model 'q ~ x + x^2 + T' --json >"$out/ten_offline.json"
if grep -q coefficient "$out/ten.json" && cmp -s <(strip "$out/ten.json") <(strip "$out/ten_offline.json"); then
  echo "equal to the daemon's model to the last digit"
else
  diff <(strip "$out/ten.json") <(strip "$out/ten_offline.json") | head -n 20
  die "the fit of the exported file differs from the daemon's (above)"
fi

say "serving: the six-sensor model"
model() { number_of model_id "$out/$1.json"; }
driftwise model promote "$(model six)"
driftwise target x=1.5
driftwise model export "$(model six)" --format c -o "$out/linear_axis_model.c"

say "proof: 50 new positions, each a minute apart, while the air drifts"
prove() { driftwise run start "$cell/trajectories/new_positions.csv" --name "proof-$1" --watch "${@:2}" >"$out/proof-$1.txt"; }
prove none
prove ten --compensate --model "$(model ten)"
prove six --compensate
prove geometry --compensate --model "$(model geometry)"
i=2
for name in none ten six geometry; do driftwise data export $i -o "$out/$name.csv"; i=$((i + 1)); done
"$bin/driftwise-demo-report" proof "$out"

say "done. Everything is in $out"
cat <<TXT
  the record            $(ls "$out/driftwise.sqlite") (SQLite: sqlite3 FILE .schema)
  campaign.csv          the measured points;   truth.csv  where the end-effector really was (the plant's private log)
  *.json                the fits;              linear_axis_model.c  the served model for a controller
  logs                  driftwised.log, cellsim.log
Next: driftwise --help, README.md
TXT
