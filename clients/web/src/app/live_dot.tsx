// ● Live 10:21:07: whether what the page shows is now, and the cell's own time as proof: the clock that every time on the page is of.
import { connection, serverTimeMs } from '@/live/connection';
import { fixed } from '@/format/numbers';
import { clock } from '@/format/time';
import { cell, cellTimeMs, isFast } from '@/live/state';
import { Mark } from '@/ui/verdict';

// Whole seconds of the cell, taken when the daemon's second changes: a fast cell's would flicker.
function cellSecond(): number | undefined {
  void serverTimeMs.value;
  return cellTimeMs.peek();
}

export function LiveDot() {
  const now = connection.value;
  const speed = cell.value?.speed || 1;
  const fast = isFast();
  return (
    <span class="bar-live" title={fast ? `The simulated cell's clock, which runs ${fixed(speed, speed < 10 ? 1 : 0)} times as fast as the wall's (${clock(serverTimeMs.value)})` : "The daemon's clock, from its heartbeat"}>
      {now.phase === 'live' && <><Mark kind="good" /><span class="strong note">Live</span> <span class="time note">{clock(fast ? cellSecond() : serverTimeMs.value)}</span></>}
      {now.phase === 'connecting' && <><Mark kind="idle" /><span class="note">Connecting</span></>}
      {now.phase === 'lost' && <><Mark kind="warn" /><span class="strong note">Not live</span></>}
    </span>
  );
}
