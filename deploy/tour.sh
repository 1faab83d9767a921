# A simulated linear axis and its daemon for this shell: `source deploy/tour.sh`. Both end with the shell, or with `tour_end`.
# Sets PATH (the programs of deploy/demo.sh or deploy/test.sh), PLAN (the published trajectory), and enters out/tour, where
# `driftwise` finds the daemon by driftwised.json. A folder of an earlier tour is kept beside it, under another name. In a
# second terminal: tells which tour runs and enters its folder, starts and deletes nothing.

tour_root=$(cd "$(dirname "${BASH_SOURCE[0]:-$0}")/.." && pwd)
tour_bin=
for tour_preset in release dev; do
  [ -x "$tour_root/build/$tour_preset/bin/driftwise-cellsim" ] && { tour_bin=$tour_root/build/$tour_preset/bin; break; }
done
tour_end() {
  [ -n "${tour_daemon:-}" ] && kill "$tour_daemon" 2>/dev/null && wait "$tour_daemon" 2>/dev/null
  [ -n "${tour_cellsim:-}" ] && kill "$tour_cellsim" 2>/dev/null && wait "$tour_cellsim" 2>/dev/null
  tour_daemon= tour_cellsim=
  return 0
}
tour_wait() {  # tour_wait FILE PID: until the file is there, for at most 30 s, or the process ends
  local i
  for i in $(seq 300); do
    [ -s "$1" ] && return 0
    kill -0 "$2" 2>/dev/null || break
    sleep 0.1
  done
  echo "the tour did not start: see the logs in $tour_root/out/tour" >&2
  return 1
}
tour_enter() {
  cd "$tour_root/out/tour" || return 1
  export PATH=$tour_bin:$PATH PLAN=$tour_root/deploy/cells/linear-axis/trajectories/published.csv
}
# The tour's programs hold the lock on descriptor 9 for as long as one of them lives, whatever becomes of their shell.
tour_start_locked() {
  local cell=$tour_root/deploy/cells/linear-axis out=$tour_root/out/tour kept
  if ! flock -n 9; then
    echo "a tour of another shell runs already: nothing was started, nothing deleted. This shell uses it too, in $out." >&2
    echo "To end it: tour_end in its own shell, or kill $(cat "$tour_root/out/tour.lock"); then source this again." >&2
    tour_enter
    return
  fi
  if [ -e "$out" ]; then
    kept=$out-kept-$(date -u +%Y%m%dT%H%M%SZ)
    while [ -e "$kept" ]; do kept=${kept}x; done
    mv "$out" "$kept" || return 1
    echo "the folder of the tour before is kept: $kept"
  fi
  mkdir -p "$out" && tour_enter || return 1
  driftwise-cellsim --plant "$cell/plant.toml" --cell "$cell/cell.toml" --instantiate "$out" --speed 200 --seed 1 \
    >"$out/cellsim.out" 2>"$out/cellsim.log" & tour_cellsim=$!
  tour_wait "$out/cellsim.out" "$tour_cellsim" || return 1
  driftwised --cell "$out/cell.toml" >"$out/driftwised.out" 2>"$out/driftwised.log" & tour_daemon=$!
  echo "$tour_cellsim $tour_daemon" >"$tour_root/out/tour.lock"
  tour_wait "$out/driftwised.json" "$tour_daemon" || return 1
  echo "a simulated linear axis and its daemon run in $out; tour_end ends them"
}
tour_start() {
  if [ -z "$tour_bin" ]; then echo "no programs yet: run deploy/demo.sh or deploy/test.sh first" >&2; return 1; fi
  tour_end
  mkdir -p "$tour_root/out" || return 1
  tour_start_locked 9>>"$tour_root/out/tour.lock"
}
trap tour_end EXIT
tour_start
