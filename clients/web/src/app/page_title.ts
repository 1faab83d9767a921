// The title of the browser's tab: alarms first, because of a tab that is not in front only the first letters are seen.
import { signal } from '@preact/signals';
import type { Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { levelWords } from '@/live/alarms';

export const viewTitle = signal('');

const mostLetters = 60; // of an alarm's message

// "▲ 2 alarms, Failed: laser-x does not answer – Now – Driftwise". Alarms in the order of the list, the worst that lasts first.
export function pageTitle(view: string, alarms: readonly Alarm[]): string {
  const plain = view ? `${view} – Driftwise` : 'Driftwise';
  const told = alarms.filter((alarm) => !alarm.shelvedUntilTime);
  const [worst] = told;
  if (!worst) return plain;
  const many = told.length > 1 ? `${told.length} alarms, ` : '';
  const message = worst.message.length > mostLetters ? `${worst.message.slice(0, mostLetters - 1)}…` : worst.message;
  return `▲ ${many}${levelWords[worst.level]}${worst.clearedTime ? ', over' : ''}: ${message} – ${plain}`;
}
