// Why commands cannot be given now; undefined: they can. Stop motion does not ask here: it is never off.
import { computed } from '@preact/signals';
import { clock } from '@/format/time';
import { connection } from './connection';

export const commandsOff = computed<string | undefined>(() => {
  const now = connection.value;
  if (now.phase === 'live') return undefined;
  if (now.phase === 'connecting') return 'Off until the first state of the cell has arrived';
  return now.lastMs === undefined ? 'Off: the daemon does not answer' : `Off: not live since ${clock(now.lastMs)}`;
});
