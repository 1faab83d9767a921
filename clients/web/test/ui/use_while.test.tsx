// An answer that takes longer than the time between two questions arrives all the same.
import { render } from '@testing-library/preact';
import { expect, test, vi } from 'vitest';
import { useAsked } from '@/ui/use_asked';
import { useWhile } from '@/ui/use_while';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine

test('a question under way is not asked again', async () => {
  let answered = 0;
  let aborted = 0;
  const ask = async (signal: AbortSignal) => {
    let underWay = true;
    signal.addEventListener('abort', () => (aborted += Number(underWay)));
    await new Promise((done) => setTimeout(done, 200));
    underWay = false;
    return ++answered;
  };
  function Slow() {
    const asked = useAsked('slow', ask);
    useWhile(true, asked, 20);
    return <p>answer {asked.value ?? 'none'}</p>;
  }
  render(<Slow />);
  await vi.waitFor(() => expect(answered).toBeGreaterThan(1), { timeout: 20_000 });
  expect(aborted).toBe(0);
});
