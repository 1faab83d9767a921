// @vitest-environment jsdom
import { render, screen } from '@testing-library/preact';
import { expect, test } from 'vitest';
import { late } from '@/ui/late';

function Drawing({ of }: { of: string }) {
  return <p>drawing of {of}</p>;
}

test('a late part keeps its place free and is shown when it is there', async () => {
  let arrive: (part: typeof Drawing) => void = () => undefined;
  const Part = late<{ of: string }>(() => new Promise((resolve) => (arrive = resolve)), 300);
  const { container } = render(<Part of="drift" />);
  expect(container.querySelector<HTMLElement>('.panel > div')?.style.minHeight).toBe('300px');
  arrive(Drawing);
  expect(await screen.findByText('drawing of drift')).toBeTruthy();
});

test('a late part that cannot be fetched says so', async () => {
  const Part = late<{ of: string }>(() => Promise.reject(new Error('404')), 300);
  render(<Part of="drift" />);
  expect((await screen.findByRole('alert')).textContent).toContain('reload the page');
});
