// The page's one polite live region: alarms and changes of state, never numbers.
import { signal } from '@preact/signals';

const said = signal('');
let together: string[] = []; // of one task: the region would keep the last one alone

export function say(sentence: string): void {
  if (together.length === 0) queueMicrotask(() => void (together = []));
  together.push(sentence);
  const whole = together.join(' ');
  said.value = said.value === whole ? `${whole}\u00a0` : whole; // the same again is said again
}

export function LiveRegion() {
  return <div class="sr-only" role="status" aria-live="polite">{said}</div>;
}
