// How far back the live panels look: 10 min, 1 h, 6 h, or since the run began. In the address as ?since=6h.
import { query, setQuery } from '@/app/router';
import { cellTimeMs, progress } from '@/live/state';
import { ms } from '@/format/time';

const windows: readonly { id: string; title: string; s: number }[] = [
  { id: '10min', title: '10 min', s: 600 },
  { id: '1h', title: '1 h', s: 3600 },
  { id: '6h', title: '6 h', s: 6 * 3600 },
  { id: 'run', title: 'run', s: 0 },
];

export function windowSeconds(): number {
  const chosen = windows.find((one) => one.id === query('since')) ?? windows[1];
  if (chosen.s > 0) return chosen.s;
  const startMs = ms(progress.value?.run?.startTime);
  const nowMs = cellTimeMs.peek();
  // By the whole quarter of an hour, so that the window does not change with every heartbeat.
  return startMs === undefined || nowMs === undefined ? 3600 : Math.max(900, Math.ceil((nowMs - startMs) / 900e3) * 900);
}

export function WindowChoice() {
  const chosen = windows.find((one) => one.id === query('since')) ?? windows[1];
  return (
    <fieldset class="segments">
      <legend class="sr-only">How far back</legend>
      {windows.map((one) => (
        <label key={one.id} class={one === chosen ? 'on' : undefined}>
          <input type="radio" name="window" checked={one === chosen} onChange={() => setQuery({ since: one.id === '1h' ? undefined : one.id })} />
          {one.title}
        </label>
      ))}
    </fieldset>
  );
}
