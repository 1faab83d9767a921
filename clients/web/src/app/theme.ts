// Light or dark: as the system says, unless a person chose. Plots read `dark` because a canvas knows no CSS variable.
import { computed, effect, signal } from '@preact/signals';
import { remembered } from './storage';

export type Theme = 'system' | 'light' | 'dark';

const system = signal(false);
export const theme = signal<Theme>((remembered.get('theme') as Theme | undefined) ?? 'system');
export const dark = computed(() => (theme.value === 'system' ? system.value : theme.value === 'dark'));

export function setTheme(chosen: Theme): void {
  theme.value = chosen;
  remembered.set('theme', chosen === 'system' ? '' : chosen);
}

export function followTheme(): void {
  const query = matchMedia('(prefers-color-scheme: dark)');
  system.value = query.matches;
  query.addEventListener('change', () => (system.value = query.matches));
  effect(() => {
    if (theme.value === 'system') document.documentElement.removeAttribute('data-theme');
    else document.documentElement.setAttribute('data-theme', theme.value);
  });
}
