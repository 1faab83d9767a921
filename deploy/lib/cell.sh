# Shared by the demos: a simulated cell and its daemon, started and ended by this script. Sourced after common.sh.

bin=$root/build/${DRIFTWISE_BUILD:-release}/bin
cellsim= daemon= taken=

finish() {
  # only what this script started, by pid
  [ -z "$daemon" ] || kill -TERM "$daemon" 2>/dev/null || true
  [ -z "$daemon" ] || wait "$daemon" 2>/dev/null || true
  [ -z "$cellsim" ] || kill -TERM "$cellsim" 2>/dev/null || true
  [ -z "$cellsim" ] || wait "$cellsim" 2>/dev/null || true
}
trap finish EXIT

need_programs() {
  local program
  for program in driftwised driftwise driftwise-cellsim driftwise-demo-report; do
    [ -x "$bin/$program" ] || die "$bin/$program is not there: run deploy/demo.sh without --no-build"
  done
}

wait_for() {  # wait_for FILE PID WHAT: until the file is there, for at most 60 s, or the process ends
  for _ in $(seq 600); do
    [ -s "$1" ] && return
    kill -0 "$2" 2>/dev/null || { tail -n 20 "$out"/*.log >&2; die "$3 ended before it was ready: its log is above, in $out"; }
    sleep 0.1
  done
  die "$3 was not ready within 60 s: see the logs in $out"
}

# start_cell NAME SPEED SEED [options of driftwise-cellsim]: sets cell (its files) and out (its folder, emptied; instance names
# another), and goes there: `driftwise` then finds the daemon by driftwised.json.
start_cell() {
  cell=$root/deploy/cells/$1
  out=$root/out/${instance:-$1}
  mkdir -p "$root/out"
  [ -z "$taken" ] || exec {taken}>&-  # of the cell before
  exec {taken}>"$out.lock"  # until this script ends
  flock -n "$taken" || die "a cell runs in $out already (deploy/demo.sh --keep in another terminal?): end that one first"
  rm -rf "$out"; mkdir -p "$out"; cd "$out"
  "$bin/driftwise-cellsim" --plant "$cell/plant.toml" --cell "$cell/cell.toml" --instantiate "$out" --speed "$2" --seed "$3" "${@:4}" \
    >"$out/cellsim.out" 2>"$out/cellsim.log" & cellsim=$!
  wait_for "$out/cellsim.out" "$cellsim" driftwise-cellsim
  "$bin/driftwised" --cell "$out/cell.toml" >"$out/driftwised.out" 2>"$out/driftwised.log" & daemon=$!
  wait_for "$out/driftwised.json" "$daemon" driftwised
}

driftwise() { "$bin/driftwise" --operator demo "$@"; }
report() { "$bin/driftwise-demo-report" "$@"; }

number_of() { sed -n "s/.*\"$1\":\([0-9]*\).*/\1/p" "$2"; }  # number_of KEY FILE, of one-line JSON
fit() { driftwise fit --run 1 --json "${@:2}" --name "$1" >"$out/$1.json"; }  # fit NAME --model FORMULA: by the daemon, on its points
model() { number_of model_id "$out/$1.json"; }
prove() { driftwise run start "$cell/trajectories/new_positions.csv" --name "proof-$1" --watch "${@:2}" >"$out/proof-$1.txt"; }

# same_offline NAME CSV FORMULA: the daemon's fit NAME, made again from the exported file, equal to the last digit.
same_offline() {
  # what limits a model is said with the rows at hand, which the daemon's client has not
  local strip='s/,"fit_us":[^,]*//; s/,"model_id":[0-9]*//; s/,"limited_by":\[[^]]*\]//'
  driftwise fit "$2" --model "$3" --json >"$out/$1_offline.json"
  if grep -q coefficient "$out/$1.json" && cmp -s <(sed -E "$strip" "$out/$1.json") <(sed -E "$strip" "$out/$1_offline.json"); then
    echo "equal to the daemon's model to the last digit"
  else
    diff <(sed -E "$strip" "$out/$1.json") <(sed -E "$strip" "$out/$1_offline.json") | head -n 20
    die "the fit of the exported file differs from the daemon's (above)"
  fi
}

page_address() { sed -n 's/.*"web": *"\([^"]*\)".*/\1/p' "$out/driftwised.json"; }

next_words() {
  cat <<TXT

Next
  deploy/demo.sh $robot --no-build --keep   the same, and its page stays open
  source deploy/tour.sh                     a cell of your own to type into: README.md, "A tour in six lines"
TXT
}

# keep_running: the page and the command line stay usable until a person ends them.
keep_running() {
  cat <<TXT

The cell and its daemon run on.
  the page      $(page_address)
  type          cd $out && PATH=$bin:\$PATH && driftwise status
  then          ${ask_words:-driftwise target x=1.5 --budget};   driftwise run list;   driftwise --help
Enter or Ctrl-C ends them.
TXT
  if [ -t 0 ]; then read -r || true; else wait "$daemon"; fi
}

closing_words() {
  say "done. Everything is in $out"
  cat <<TXT
  the record            $(ls "$out/driftwise.sqlite") (SQLite: sqlite3 FILE .schema)
  campaign.csv          the measured points;   truth.csv  where the end-effector really was (the plant's private log)
  *.json                the fits;              $1
  logs                  driftwised.log, cellsim.log
TXT
}
