# Case A of the published study: one linear axis. Sourced by demo.sh.

default_speed=200

proof_runs='none ten six geometry'  # runs 2 to 5

# the models of run 1 and of campaign.csv, and their table
demo_fits() {
  fit geometry --model 'q ~ x + x^2'
  fit ten --model 'q ~ x + x^2 + t01..t10'
  fit six --model 'q ~ x + x^2 + t05..t10'
  fit first300 --model 'q ~ x + x^2 + t01..t10' --first 300
  driftwise fit "$out/campaign.csv" --model 'q ~ x + x^2 + t01..t10' --offers --json >"$out/offers.json"
  report linear-axis fits "$out"
}

demo() {
  say "the simulated cell and the daemon, speed $speed, seed $seed"
  start_cell linear-axis "$speed" "$seed"
  driftwise status

  say "the campaign: 18 positions 56 times, 1008 points of 4 readings, four hours of cell time"
  driftwise run start "$cell/trajectories/published.csv" --name campaign --watch
  driftwise data export 1 -o "$out/campaign.csv"

  say "models: fitted by the daemon on its stored points"
  demo_fits

  say "the same fit on the exported file, without the daemon"
  same_offline ten "$out/campaign.csv" 'q ~ x + x^2 + t01..t10'

  say "serving: the six-sensor model"
  driftwise model promote "$(model six)"
  driftwise target x=1.5
  driftwise model export "$(model six)" --format c -o "$out/linear_axis_model.c"

  say "proof: 50 new positions, each a minute apart, while the air drifts"
  prove none
  prove ten --compensate --model "$(model ten)"
  prove six --compensate
  prove geometry --compensate --model "$(model geometry)"
  local i=2 name
  for name in $proof_runs; do
    driftwise data export $i -o "$out/$name.csv"
    driftwise run verify $i --json >"$out/$name.verify.json"
    i=$((i + 1))
  done
  say "what compensation achieved: six sensors against no compensation"
  driftwise run verify 4 2
  report linear-axis proof "$out"
  closing_words "linear_axis_model.c  the served model for a controller"
}
