// The keyboard: g and a letter goes to a view, / to the search field, j and k through rows, Enter opens one, ? helps. Off
// inside fields and dialogs, and altogether when a person switched it off.
import { signal } from '@preact/signals';
import { go } from './router';
import { remembered } from './storage';
import { views } from './views';

export const keysOn = signal(remembered.get('keys') !== 'off');
export const helpOpen = signal(false);

export function setKeysOn(on: boolean): void {
  keysOn.value = on;
  remembered.set('keys', on ? '' : 'off');
}

const withinField = (at: EventTarget | null) =>
  at instanceof Element && at.closest('input, textarea, select, dialog, [contenteditable]') !== null;

function moveRow(by: 1 | -1): void {
  const links = [...document.querySelectorAll<HTMLElement>('main [data-row]')].map((row) => row.querySelector<HTMLElement>('a, button') ?? row);
  if (links.length === 0) return;
  const at = links.findIndex((link) => link === document.activeElement);
  const next = links[at < 0 ? 0 : Math.min(links.length - 1, Math.max(0, at + by))];
  if (!next.matches('a, button')) next.tabIndex = -1;
  next.focus();
}

let afterG = 0; // when g was pressed

function press(event: KeyboardEvent): void {
  if (!keysOn.value || event.ctrlKey || event.metaKey || event.altKey || withinField(event.target)) return;
  const view = event.timeStamp - afterG < 1500 ? views.find((one) => one.key === event.key) : undefined;
  afterG = event.key === 'g' ? event.timeStamp : -Infinity;
  if (view) go(`/${view.name}`);
  else if (event.key === '?') helpOpen.value = true;
  else if (event.key === 'j') moveRow(1);
  else if (event.key === 'k') moveRow(-1);
  else if (event.key === '/') document.querySelector<HTMLElement>('main input[type=search]')?.focus();
  else return;
  event.preventDefault();
}

export function followKeys(): void {
  addEventListener('keydown', press);
}
