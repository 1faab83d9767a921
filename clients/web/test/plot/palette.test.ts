import { expect, it } from 'vitest';
import css from '@/styles/tokens.css?raw';
import { paletteOf } from '@/plot/palette';

it('has the same colours as the style sheet', () => {
  for (const [name, light] of Object.entries(paletteOf(false))) {
    const found = new RegExp(`--${name}: (?:light-dark\\((#\\w+), (#\\w+)\\)|(#\\w+));`).exec(css);
    expect(found, name).not.toBeNull();
    const [, ofLight, ofDark, both] = found!;
    expect([name, ofLight ?? both, ofDark ?? both]).toEqual([name, light, paletteOf(true)[name as 'page']]);
  }
});
