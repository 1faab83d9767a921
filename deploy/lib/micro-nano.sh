# Case B of the published study: the three-axis Agietron Micro-Nano under heat and force. Sourced by demo.sh.

default_speed=200
ask_words='driftwise target x=0.2 y=-0.1 z=1.2 force=0.392 --budget'
proof_runs='compensated products geometry'  # runs 2 to 4

geometry='poly(x, y, z, 3)' force='F + F^2 + F^3' heat='t04..t10'
# what this plant needs beyond the study's terms: docs/fitting.md
products="q ~ poly(x, y, z, 4) + $force + $heat + (F + t04):poly(x, y, z, 2)"

# rows_with_force FORCE: the calibration rows of campaign.csv and the validation rows at that force, N
rows_with_force() {
  awk -F, -v force="$1" '
    /^#/ { print; next }
    !columns { for (i = 1; i <= NF; i++) column[$i] = i; columns = 1; print; next }
    $column["set"] == "calibration" || ($column["force_N"] - force) ^ 2 < 0.05 ^ 2' "$out/campaign.csv"
}

# the models of run 1 and of campaign.csv, and their table
demo_fits() {
  fit G --model "q ~ $geometry"
  fit GF --model "q ~ $geometry + $force"
  fit GT --model "q ~ $geometry + $heat"
  fit GTF --model "q ~ $geometry + $force + $heat"
  fit products --model "$products"
  rows_with_force 0.768 >"$out/inside.csv"
  rows_with_force 3.842 >"$out/outside.csv"
  local where name
  for where in inside outside; do
    driftwise fit "$out/$where.csv" --model "q ~ $geometry" --json >"$out/G_$where.json"
    driftwise fit "$out/$where.csv" --model "q ~ $geometry + $force" --json >"$out/GF_$where.json"
    driftwise fit "$out/$where.csv" --model "q ~ $geometry + $heat" --json >"$out/GT_$where.json"
    driftwise fit "$out/$where.csv" --model "q ~ $geometry + $force + $heat" --json >"$out/GTF_$where.json"
    driftwise fit "$out/$where.csv" --model "$products" --json >"$out/products_$where.json"
  done
  driftwise fit "$out/inside.csv" --model "q ~ $geometry + $force + $heat" --offers --json >"$out/offers.json"
  report micro-nano fits "$out"
}

demo() {
  say "the simulated cell and the daemon, speed $speed, seed $seed"
  start_cell micro-nano "$speed" "$seed"
  driftwise status

  say "the plan checks itself: the published order of forces, and one that rises with the warming room"
  driftwise trajectory check "$cell/trajectories/published.csv"
  driftwise trajectory grid --axes q1,q2,q3 --block 'calibration 0:2.5:0.5 force=0' --block 'calibration 0:2.5:0.5 force=1.536' \
    --block 'calibration 0:2.5:0.5 force=2.305' --block 'validation 0.25:2.25:0.5 force=0.768' -o "$out/rising.csv"
  driftwise trajectory check "$out/rising.csv"

  say "the campaign: 756 calibration and 300 validation points, five forces, 5.5 hours of cell time"
  driftwise run start "$cell/trajectories/published.csv" --name campaign --watch
  driftwise data export 1 -o "$out/campaign.csv"

  say "models: fitted by the daemon on its stored points, judged inside and outside the range of forces"
  demo_fits

  say "the same fit on the exported file, without the daemon"
  same_offline GTF "$out/campaign.csv" "q ~ $geometry + $force + $heat"

  say "serving: geometry, force and temperatures"
  driftwise model promote "$(model GTF)"
  driftwise target x=0.2 y=-0.1 z=1.2 force=0.392
  driftwise model export "$(model GTF)" --format c -o "$out/micro_nano_model.c"

  say "proof: 94 new positions under 40 g while the air drifts"
  prove compensated --compensate
  prove products --compensate --model "$(model products)"
  prove geometry --compensate --model "$(model G)"
  local i=2
  for name in $proof_runs; do
    driftwise data export $i -o "$out/$name.csv"
    driftwise run verify $i --json >"$out/$name.verify.json"
    i=$((i + 1))
  done
  say "what compensation achieved: force and temperatures against geometry only"
  driftwise run verify 2 4
  report micro-nano proof "$out"
  closing_words "micro_nano_model.c  the served model for a controller"
}
