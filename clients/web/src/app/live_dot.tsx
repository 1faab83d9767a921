// ● Live 10:21:07: whether what the page shows is now, and the daemon's own time as proof.
import { connection, serverTimeMs } from '@/live/connection';
import { clock } from '@/format/time';
import { Mark } from '@/ui/verdict';

export function LiveDot() {
  const now = connection.value;
  return (
    <span class="bar-live" title="The daemon's clock, from its heartbeat">
      {now.phase === 'live' && <><Mark kind="good" /><span class="strong note">Live</span> <span class="time note">{clock(serverTimeMs.value)}</span></>}
      {now.phase === 'connecting' && <><Mark kind="idle" /><span class="note">Connecting</span></>}
      {now.phase === 'lost' && <><Mark kind="warn" /><span class="strong note">Not live</span></>}
    </span>
  );
}
