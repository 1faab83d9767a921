#include "clients/cli/examples.h"

#include <algorithm>
#include <array>

namespace driftwise::cli {
namespace {

constexpr auto kExamples = std::to_array<Example>({
    {"status", "driftwise status", "what the cell does, and what needs attention"},
    {"status", "driftwise status --json", "the same for a script"},
    {"devices", "driftwise devices", "every device, its address, its link and its errors"},
    {"alarms", "driftwise alarms", "what asks for a person now"},
    {"alarms acknowledge", "driftwise alarms acknowledge 4", "you have seen alarm 4"},
    {"events", "driftwise events --follow", "the record, and what happens next"},
    {"events", "driftwise events --after 120 --json", "what came after event 120"},
    {"readings", "driftwise readings laser", "the readings of one instrument as they come"},
    {"trajectory check", "driftwise trajectory check plan.csv",
     "limits, counts, duration, what a fit could not tell apart"},
    {"trajectory upload", "driftwise trajectory upload plan.csv --name 'case B'",
     "checks the plan and keeps it in the daemon"},
    {"trajectory list", "driftwise trajectory list", "the plans that are kept"},
    {"trajectory show", "driftwise trajectory show 3 > plan.csv", "a kept plan as it was uploaded"},
    {"trajectory generate",
     "driftwise trajectory generate --axis q1_mm=0:2.5:6 --axis q2_mm=0:2.5:6 --validation -o "
     "plan.csv",
     "a grid of 36 with validation in between"},
    {"trajectory grid",
     "driftwise trajectory grid --axes q1 --block 'calibration -4:4:0.5' -o plan.csv",
     "positions every half millimetre, with returns to zero"},
    {"trajectory grid",
     "driftwise trajectory grid --axes q1,q2,q3 --block 'calibration 0:2.5:0.5 force=2.305' "
     "--block 'validation 0.1:2.4 scattered=94 seed=7'",
     "a grid under a force, then scattered points"},
    {"trajectory iso230-2", "driftwise trajectory iso230-2 --from -4 --to 4 -o iso.csv",
     "five passes from both sides"},
    {"trajectory iso230-3", "driftwise trajectory iso230-3 --at -4,4 --hours 8 -o drift.csv",
     "two positions again and again for a working day"},
    {"trajectory iso9283",
     "driftwise trajectory iso9283 --centre 1.25,1.25,1.25 --edge 1 -o cube.csv",
     "five poses, thirty cycles"},
    {"run start", "driftwise run start weekend.csv --watch", "measure, with a progress bar"},
    {"run start", "driftwise run start check.csv --compensate --model 12",
     "move to the targets of a model"},
    {"run start", "driftwise run start plan.csv --dry-run", "only say what it would do"},
    {"run list", "driftwise run list --limit 5", "the last five"},
    {"run show", "driftwise run show 17", "one run, with its notes"},
    {"run watch", "driftwise run watch", "the one under way, to its end"},
    {"run pause", "driftwise run pause 17", "after the point under way"},
    {"run resume", "driftwise run resume 17", "goes on where it was"},
    {"run abort", "driftwise run abort 17 --reason 'door open'", "at once; what is stored stays"},
    {"run confirm", "driftwise run confirm 17 --force 2.305", "the weights hang now"},
    {"run points", "driftwise run points 17 --json", "every accepted point"},
    {"run attempts", "driftwise run attempts 17", "every attempt, and why it was not accepted"},
    {"run datums", "driftwise run datums 17", "every zeroing and its temperatures"},
    {"stop", "driftwise stop", "halts all axes, from any client"},
    {"home", "driftwise home --dry-run", "what it would do"},
    {"move", "driftwise move q1=0.5", "one axis, mm"},
    {"move", "driftwise move q1=0.5 q2=1 q3=0", "three axes, mm"},
    {"stabiliser", "driftwise stabiliser support 23.0", "set-point in degrees Celsius"},
    {"lease show", "driftwise lease show", "who may move"},
    {"lease take", "driftwise lease take --hold 600", "for ten minutes of cell time"},
    {"lease give-up", "driftwise lease give-up TOKEN", "others may move"},
    {"data export", "driftwise data export 17 18 -o campaign.csv", "two runs as one dataset"},
    {"data import", "driftwise data import campaign.csv --name 'campaign of May'",
     "a dataset becomes a run that is done"},
    {"data import", "driftwise data import tracker.csv.gz --mapping map.toml -o data.csv",
     "another program's table as a dataset, no daemon"},
    {"data exclude", "driftwise data exclude 17 --rows 12,40-45 --reason 'lorry passed'",
     "these rows enter no fit"},
    {"data restore", "driftwise data restore 17 --rows 12 --reason 'it was the other one'",
     "back into fits"},
    {"data exclusions", "driftwise data exclusions 17", "what is out, and who said so"},
    {"note add", "driftwise note add 'new mirror since today' --run 17", "on a run"},
    {"note list", "driftwise note list --model 3", "what was said of a model"},
    {"fit", "driftwise fit data.csv --model 'q ~ poly(x, y, z, 3) + F + T'",
     "a file alone, no daemon needed"},
    {"fit", "driftwise fit --run 3 --model 'q ~ x + x^2 + T' --history",
     "a run; the daemon stores the model"},
    {"fit", "driftwise fit data.csv --model 'q ~ x + lag(t07, 1800 s)' --select all --json",
     "no selection, for a script"},
    {"diagnose", "driftwise diagnose weekend.csv --baseline 'q1 ~ x + x^2 + T'",
     "what this simulation gets wrong in these data, and why"},
    {"model list", "driftwise model list", "oldest first"},
    {"model show", "driftwise model show 3", "the page to sign"},
    {"model compare", "driftwise model compare 3 4", "term by term"},
    {"model compare",
     "driftwise model compare data.csv --kinematics robot.toml --model 'q ~ poly(x, y, z, 2)'",
     "methods side by side on one file"},
    {"model promote", "driftwise model promote 4", "it serves targets from now on"},
    {"model check", "driftwise model check --runs 20,21", "exit code 1: recalibrate now"},
    {"model sensors", "driftwise model sensors data.csv --model 'q ~ x + T'",
     "what each thermometer fewer costs"},
    {"model rollback", "driftwise model rollback", "the one before serves again"},
    {"model history", "driftwise model history", "what served when, and who said so"},
    {"model export", "driftwise model export 4 --format c -o model_4.c", "for a controller"},
    {"target", "driftwise target x=1.5", "motor coordinates for a pose"},
    {"target", "driftwise target x=0.5 y=0 z=1 rx=0 force=0.768 --budget",
     "with what the uncertainty is made of"},
    {"target", "driftwise target x=1.5 --watch --json", "one line whenever the conditions change"},
    {"standard iso230-2", "driftwise standard iso230-2 --run 5", "A, R, E, M and B of an axis"},
    {"standard iso230-3", "driftwise standard iso230-3 drift.csv", "thermal drift, of a file"},
    {"standard iso9283", "driftwise standard iso9283 --run 6 --json", "AP and RP of a robot"},
    {"completion",
     "driftwise completion bash > ~/.local/share/bash-completion/completions/driftwise",
     "for bash, where it looks for them"},
    {"completion", "driftwise completion fish > ~/.config/fish/completions/driftwise.fish",
     "for fish"},
    {"man", "driftwise man run | man -l -", "read one page"},
    {"man", "driftwise man --into /usr/local/share/man/man1", "write them all"},
});

}  // namespace

std::span<const Example> all_examples() { return kExamples; }

std::span<const Example> examples_of(std::string_view verb) {
  const auto is_its = [&](const Example& one) { return one.verb == verb; };
  const auto first = std::find_if(kExamples.begin(), kExamples.end(), is_its);
  const auto last = std::find_if_not(first, kExamples.end(), is_its);
  return {first, last};
}

}  // namespace driftwise::cli
