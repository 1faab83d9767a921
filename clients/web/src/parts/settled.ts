// When a stabiliser counts as settled: within the band of the rule by which the daemon holds a run ([checks] stabiliser_band_k
// of the cell file), the same on every view.
import { signal } from '@preact/signals';
import { api } from '@/api/client';
import type { Hold } from '@/api/gen/driftwise/v1/cell_service_pb';

// As the cell file has it unless it says otherwise; also where no rule holds a run on its stabilisers.
const usualBandK = 0.01;
const bandK = signal(usualBandK);
let asked = false;

// Of the rules: that of a temperature less its own set-point.
export function bandOf(holds: readonly Hold[]): number {
  const band = holds.find((hold) => hold.minusChannel === hold.channel.replace(/_degC$/, '_set_degC') && hold.above !== undefined);
  return band?.above ?? usualBandK;
}

// Reading it makes a component follow the band.
export function settledK(): number {
  if (!asked) {
    asked = true;
    api.cell().listHolds({}).then(({ holds }) => (bandK.value = bandOf(holds)), () => (asked = false));
  }
  return bandK.value;
}
