// Colours between two others, for maps and pictures of one hue. Plain RGB: the steps are for the eye, the figures stand
// in tables.
const channels = (hex: string): [number, number, number] => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)) as [number, number, number];

// share 0: from, 1: to.
export function mix(from: string, to: string, share: number): string {
  const [a, b] = [channels(from), channels(to)];
  const part = Math.min(1, Math.max(0, share));
  return '#' + a.map((value, i) => Math.round(value + (b[i] - value) * part).toString(16).padStart(2, '0')).join('');
}

// Symmetric about zero: the first colour at -reach, the panel at 0, the last at +reach.
export function diverging(value: number, reach: number, colours: { panel: string; q1: string; q2: string }): string {
  const share = reach > 0 ? Math.min(1, Math.abs(value) / reach) : 0;
  return mix(colours.panel, value < 0 ? colours.q1 : colours.q2, share);
}
