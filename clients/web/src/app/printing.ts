// Whether the page is being printed: tables then hold every row and column, plots are drawn for paper.
import { signal } from '@preact/signals';
import { options } from 'preact';

export const printing = signal(false);

// The browser takes its picture as soon as the event's listeners are done: what is rendered later is not on paper.
function now(change: () => void): void {
  const usual = options.debounceRendering;
  options.debounceRendering = (render) => render();
  change();
  options.debounceRendering = usual;
}

export function followPrinting(): () => void {
  const before = () => now(() => (printing.value = true));
  const after = () => (printing.value = false);
  addEventListener('beforeprint', before);
  addEventListener('afterprint', after);
  return () => {
    removeEventListener('beforeprint', before);
    removeEventListener('afterprint', after);
  };
}
