// One frame for everything that moves.
import { expect, it, vi } from 'vitest';
import { askForPaint, paintFirst, plotTick } from '@/live/paint';

it('takes what came since the last frame first, once a frame however often it was asked for', async () => {
  const seen: string[] = [];
  paintFirst(() => seen.push(`news before tick ${plotTick.value}`));
  const before = plotTick.value;
  const end = plotTick.subscribe((tick) => tick !== before && seen.push(`plots, tick ${tick}`));
  for (let i = 0; i < 5; i++) askForPaint();
  await vi.waitFor(() => {
    askForPaint();
    expect(seen).toContain(`plots, tick ${before + 1}`);
  });
  expect(seen.slice(-2)).toEqual([`news before tick ${before}`, `plots, tick ${before + 1}`]);
  end();
});
