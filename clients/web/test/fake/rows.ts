// Rows as a campaign of a three-axis robot would give them, from a seed: for tests of views and for looking at a page
// without a daemon. Not shipped.
export function random(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

export function normal(next: () => number): number {
  return Math.sqrt(-2 * Math.log(next() + 1e-12)) * Math.cos(2 * Math.PI * next());
}

export interface Campaign {
  timeS: number[];
  validation: boolean[];
  line: number[];
  variables: { symbol: string; unit: string; values: number[] }[];
}

export function campaign(rows = 420): Campaign {
  const next = random(7);
  const index = Array.from({ length: rows }, (_, i) => i);
  const timeS = index.map((i) => i * 19);
  const pose = (k: number) => index.map((i) => ((i * (k + 1) * 7) % 11) / 5 - 1 + 0.001 * normal(next));
  const warm = (phase: number, size: number) => timeS.map((t) => 22 + size * Math.sin(t / 5000 + phase) + 0.002 * normal(next));
  return {
    timeS, validation: index.map((i) => i % 5 === 4), line: index.map((i) => Math.floor(i / 12) + 1),
    variables: [
      { symbol: 'x', unit: 'mm', values: pose(0) }, { symbol: 'y', unit: 'mm', values: pose(1) }, { symbol: 'z', unit: 'mm', values: pose(2) },
      { symbol: 'force', unit: 'N', values: index.map((i) => [0, 0.768, 1.536][Math.floor((3 * i) / rows)]) },
      ...['t04', 't05', 't06', 't07', 't08', 't09', 't10'].map((symbol, k) => ({ symbol, unit: 'degC', values: warm(k, 0.4 + 0.1 * k) })),
    ],
  };
}
