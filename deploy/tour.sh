# A simulated linear axis and its daemon for this shell: `source deploy/tour.sh`. Both end with the shell, or with `tour_end`.
# Sets PATH (the programs of deploy/demo.sh or deploy/test.sh), PLAN (the published trajectory), and enters out/tour, where
# `driftwise` finds the daemon by driftwised.json.

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
tour_start() {
  local cell=$tour_root/deploy/cells/linear-axis out=$tour_root/out/tour
  if [ -z "$tour_bin" ]; then echo "no programs yet: run deploy/demo.sh or deploy/test.sh first" >&2; return 1; fi
  tour_end
  rm -rf "$out"; mkdir -p "$out"; cd "$out" || return 1
  export PATH=$tour_bin:$PATH PLAN=$cell/trajectories/published.csv
  driftwise-cellsim --plant "$cell/plant.toml" --cell "$cell/cell.toml" --instantiate "$out" --speed 200 --seed 1 \
    >"$out/cellsim.out" 2>"$out/cellsim.log" & tour_cellsim=$!
  tour_wait "$out/cellsim.out" "$tour_cellsim" || return 1
  driftwised --cell "$out/cell.toml" >"$out/driftwised.out" 2>"$out/driftwised.log" & tour_daemon=$!
  tour_wait "$out/driftwised.json" "$tour_daemon" || return 1
  echo "a simulated linear axis and its daemon run in $out; tour_end ends them"
}
trap tour_end EXIT
tour_start
