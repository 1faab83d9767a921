// When a stabiliser counts as settled: [checks] stabiliser_band_k of the cell file, as the daemon's checks have it. The same on
// every view.
import { signal } from '@preact/signals';
import { api } from '@/api/client';

// Until the daemon has said it.
const usualBandK = 0.01;
const bandK = signal(usualBandK);
let asked = false;

// Reading it makes a component follow the band. device: any stabiliser of the cell.
export function settledK(device: string): number {
  if (!asked) {
    asked = true;
    api.cell().getStabiliser({ deviceId: device }).then(({ settledBandK }) => (bandK.value = settledBandK), () => (asked = false));
  }
  return bandK.value;
}
