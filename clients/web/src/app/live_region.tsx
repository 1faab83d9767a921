// The page's one polite live region: alarms and changes of state, never numbers.
import { signal } from '@preact/signals';

const said = signal('');

export function say(sentence: string): void {
  said.value = said.value === sentence ? `${sentence}\u00a0` : sentence; // the same again is said again
}

export function LiveRegion() {
  return <div class="sr-only" role="status" aria-live="polite">{said}</div>;
}
