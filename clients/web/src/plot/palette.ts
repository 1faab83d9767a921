// The colours of styles/tokens.css for canvas and SVG, which know no CSS variable.
import { dark } from '@/app/theme';

const light = {
  page: '#f4f6f8', panel: '#ffffff', text: '#16202a', muted: '#4f5b67', line: '#d5dbe1', grid: '#e6eaee', zero: '#7a8691',
  q1: '#433bcf', q2: '#9e1d0b', q3: '#0a9c82', s4: '#a77ddf', s5: '#bb7f0a', s6: '#2b333c',
  good: '#0073aa', warn: '#7a6f00', bad: '#8d0044', idle: '#59626c', hatch: '#eef0f2',
};
export type Palette = typeof light;
const darkness: Palette = {
  page: '#0f1419', panel: '#181f27', text: '#e6ebf0', muted: '#a3afba', line: '#2e3944', grid: '#26303a', zero: '#7a8691',
  q1: '#7376ff', q2: '#c85d32', q3: '#b1ffb9', s4: '#a198b3', s5: '#f4a823', s6: '#eef2f6',
  good: '#59e8fc', warn: '#ffe85c', bad: '#e0616a', idle: '#8a97a3', hatch: '#222b34',
};

export const paletteOf = (isDark: boolean): Palette => (isDark ? darkness : light);
export const palette = (): Palette => paletteOf(dark.value);
