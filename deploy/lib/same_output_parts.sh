# What same_output.sh makes and compares. Sourced after common.sh; `keep` is the folder of the outputs.

source "$root/deploy/lib/cell.sh"

robot=$root/tests/data/robots/ur10.toml
seeds_per_kind=13

# make_sets: 60 data sets in $keep/sets. The file `list` has one line each: name, file, formula ("kinematics": a robot's drawing
# instead), further options of a diagnosis.
make_sets() {
  cd "$keep/sets"
  local kind line
  for kind in null single pair unlisted; do
    "$before/foreign_generator" --first-seed 1 --count $seeds_per_kind --kind $kind --chi2 150 --out . >/dev/null
  done
  sed -n 's/^{"file":"\([^"]*\)\.csv".*"baseline":"\([^"]*\)".*/\1\t\1.csv\t\2\t/p' key.jsonl >list

  local data=$root/tests/data
  cp "$data/ur10_laser_tracker/series_a_subset.csv" ur10_subset.csv
  gunzip -c "$data/ur10_laser_tracker/series_d_iso_cubes.csv.gz" >iso_cubes.csv
  "$before/driftwise" data import iso_cubes.csv --mapping "$root/deploy/mappings/ur10_laser_tracker_d.toml" -o ur10_cubes.csv >/dev/null 2>&1
  cp "$data/databases/version_1_cell_run_1.csv" "$data/standards/"iso*.csv .
  for line in linear-axis micro-nano; do
    stored_cell $line "$keep/sets/$line" 1
    with_daemon "$before" "$keep/sets/$line" "$before/driftwise" data export 1 -o "$keep/sets/$line.csv"
  done
  {
    printf '%s\t%s\t%s\t%s\n' ur10_subset ur10_subset.csv kinematics '' ur10_cubes ur10_cubes.csv kinematics '' \
      version_1 version_1_cell_run_1.csv 'q ~ x' '' iso230_2 iso230_2.csv 'q ~ x' '' iso230_3 iso230_3.csv 'x ~ q1_cmd' '' \
      iso9283 iso9283.csv 'x ~ poly(x_target, y_target, z_target, 2)' '' linear-axis linear-axis.csv 'q ~ x + x^2' '' \
      micro-nano micro-nano.csv 'q ~ poly(x, y, z, 3) + F + F^2 + F^3 + t04..t10' '--nulls 20 --most 1'
  } >>list
}

# stored_cell DEMO FOLDER PORT: the demo's cell file and its record, tests/data/demos. All devices are at PORT, where nobody
# listens; daemons at work at the same time need ports of their own, for one controller has one daemon.
stored_cell() {
  mkdir -p "$2"
  gunzip -c "$root/tests/data/demos/$1.sql.gz" | sqlite3 "$2/driftwise.sqlite"
  sqlite3 "$2/driftwise.sqlite" 'SELECT text FROM cell_config LIMIT 1' | sed 's/^speed = .*/speed = 1/; s/"127\.0\.0\.1:[1-9][0-9]*"/"127.0.0.1:'"$3"'"/' >"$2/cell.toml"
}

# with_daemon BIN FOLDER COMMAND...: the command in a folder of stored_cell while a daemon serves it
with_daemon() (
  cd "$2"
  rm -f driftwised.json
  "$1/driftwised" --cell cell.toml >driftwised.out 2>driftwised.log & daemon=$!
  trap 'kill -TERM $daemon 2>/dev/null; wait $daemon 2>/dev/null' EXIT
  for _ in $(seq 600); do
    [ -s driftwised.json ] && break
    kill -0 $daemon 2>/dev/null || { tail -n 5 driftwised.log >&2; exit 5; }
    sleep 0.1
  done
  "${@:3}"
)

# put FILE COMMAND...: standard output, standard error and exit code of a command, masked, in FILE.out, FILE.err and FILE.code
put() {
  local code=0
  "${@:2}" >"$1.out" 2>"$1.err" || code=$?
  echo $code >"$1.code"
  sed -E -i 's/"fit_us":[^,}]*/"fit_us":0/g; s/"model_id":[0-9]*/"model_id":0/g; s/ *[0-9.]+ ms$/ - ms/;
             s/"(version|commit)":"[^"]*"/"\1":""/g' "$1.out" "$1.err"
}

# side_outputs BIN FOLDER PORT: everything that is compared, of one side
side_outputs() {
  mkdir -p "$2/fit" "$2/diagnose" "$2/coverage" "$2/demos"
  local name file formula options demo plant
  cd "$keep/sets"
  while IFS=$'\t' read -r name file formula options; do
    if [ "$formula" = kinematics ]; then
      put "$2/fit/$name" "$1/driftwise" fit "$file" --method kinematic --kinematics "$robot" --json
      put "$2/diagnose/$name" "$1/driftwise" diagnose "$file" --kinematics "$robot" --json
    else
      put "$2/fit/$name" "$1/driftwise" fit "$file" --model "$formula" --offers --json
      # shellcheck disable=SC2086  # options are words
      put "$2/diagnose/$name" "$1/driftwise" diagnose "$file" --baseline "$formula" $options --json
    fi
  done <list
  for plant in micro-nano linear-axis; do
    put "$2/coverage/$plant" "$1/coverage" --plant $plant --campaigns 20 --first-seed 3001
  done
  for demo in linear-axis micro-nano; do
    stored_cell $demo "$2/work-$demo" "$3"
    with_daemon "$1" "$2/work-$demo" stored_demo "$1" "$2/demos" $demo
  done
}

# stored_demo BIN FOLDER DEMO: the demo's tables from its stored campaign and proof runs, and what they are made from
stored_demo() {
  local to=$2 demo=$3 name i=2 json
  bin=$1 out=$PWD
  source "$root/deploy/lib/$demo.sh"
  gunzip -c "$root/tests/data/demos/$demo-truth.csv.gz" >truth.csv
  driftwise data export 1 -o campaign.csv
  for name in $proof_runs; do
    driftwise data export $i -o "$name.csv"
    driftwise run verify $i --json >"$name.verify.json"
    i=$((i + 1))
  done
  put "$to/$demo-fits" demo_fits
  put "$to/$demo-proof" report $demo proof .
  for name in *.json; do [ "$name" = driftwised.json ] || put "$to/$demo-$name" cat "$name"; done
  for name in campaign $proof_runs; do put "$to/$demo-$name.csv" cat $name.csv; done
}

# compare_sides: a table of what was compared, and the first difference
compare_sides() {
  local part file kind differs first=
  printf '%-40s %10s %10s\n' "what (text, messages, exit code)" compared different
  for part in fit diagnose coverage demos; do
    local outputs=0 different=0
    while read -r file; do
      outputs=$((outputs + 1)) differs=no
      for kind in code err out; do
        cmp -s "$keep/before/$part/$file.$kind" "$keep/after/$part/$file.$kind" && continue
        differs=yes; first=${first:-$part/$file.$kind}
      done
      [ $differs = no ] || different=$((different + 1))
    done < <(ls "$keep/before/$part" "$keep/after/$part" | sed -n 's/\.code$//p' | sort -u)
    printf '%-40s %10d %10d\n' "$(title_of $part)" $outputs $different
  done
  echo "Outputs: $keep/before and $keep/after"
  [ -n "$first" ] || return 0
  printf '\nfirst difference: %s\n' "$first"
  show_difference "$keep/before/$first" "$keep/after/$first"
  return 1
}

# show_difference A B: the bytes about the first one that differs
show_difference() {
  local at from file
  for file in "$1" "$2"; do [ -e "$file" ] || { echo "$file is not there"; return; }; done
  at=$(cmp -l "$1" "$2" 2>/dev/null | head -n 1 | awk '{ print $1 }' || true)
  [ -n "$at" ] || at=$(wc -c <"$1")  # one is the other's beginning
  from=$((at > 80 ? at - 80 : 1))
  echo "byte $at:"
  for file in "$1" "$2"; do printf '  %s\n' "$(tail -c +$from "$file" | head -c 160 | tr '\n' '|')"; done
}

title_of() {
  case $1 in
    fit) echo "fit --json, data sets" ;;
    diagnose) echo "diagnose --json, data sets" ;;
    coverage) echo "coverage, 20 campaigns each, plants" ;;
    demos) echo "demos: tables, models, runs" ;;
  esac
}
