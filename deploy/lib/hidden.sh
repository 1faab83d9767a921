# Hide it yourself: a second cell hides a cause that is drawn with the day's date, `driftwise improve` looks for it on the wire,
# and the sealed answer is opened. Sourced by demo.sh.

# hidden_chapter SEED: in a subshell, beside the cell of the demo, which may run on.
hidden_chapter() (
  cellsim= daemon= taken= instance=hidden
  trap finish EXIT
  say "hide it yourself: a cell hides something, drawn with seed $1"
  start_cell linear-axis 400 "$1" --hide random --sealed "$root/out/hidden-answer.json"
  driftwise trajectory generate --axis q1_mm=-3.9:3.9:18 --both-directions --repeat 14 --validation -o grid.csv
  # 22 s at each place: a run takes four hours, in which a room drifts and what is slow shows itself
  awk '/^#/ { print; next } !header { header = 1; print $0 ",dwell_s"; next } { print $0 ",22" }' grid.csv >plan.csv
  driftwise improve plan.csv --model 'q ~ x + x^2 + T' --max-turns 1 --json >improvement.json || true
  driftwise improve show 1 || true
  driftwise diagnosis show 1 --json >diagnosis.json || [ -s diagnosis.json ]  # its exit code is a verdict
  mv "$root/out/hidden-answer.json" sealed.json
  local found=0
  report hidden "$out" || found=$?
  [ "$found" -le 1 ] || die "the report of what was found failed ($found)"
  [ "$found" = 0 ] || echo "Not everything was found: what a run of four hours on 18 positions can show is limited (docs/limits.md)."
)
