// Zoom and pan without a select box: keys + - 0 and arrows, Ctrl-wheel, shift-drag, two fingers.
import type { Range } from './ranges';

export interface Gestured {
  seen: () => Range;
  zoom: (range: Range | undefined) => void;
  xAt: (clientX: number) => number; // unit of x
}

export function scaled({ from, to }: Range, by: number, about = (from + to) / 2): Range {
  return { from: about - (about - from) * by, to: about + (to - about) * by };
}

export function moved({ from, to }: Range, by: number): Range {
  return { from: from + by, to: to + by };
}

// true: the key meant something.
export function keyPressed(key: string, { seen, zoom }: Gestured): boolean {
  const range = seen();
  const width = range.to - range.from;
  switch (key) {
    case '+': case '=': zoom(scaled(range, 0.5)); return true;
    case '-': case '−': zoom(scaled(range, 2)); return true;
    case '0': zoom(undefined); return true;
    case 'ArrowLeft': zoom(moved(range, -width / 5)); return true;
    case 'ArrowRight': zoom(moved(range, width / 5)); return true;
    default: return false;
  }
}

export function followGestures(over: HTMLElement, of: Gestured): void {
  over.addEventListener('wheel', (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    of.zoom(scaled(of.seen(), event.deltaY > 0 ? 1.25 : 0.8, of.xAt(event.clientX)));
  }, { passive: false });

  const fingers = new Map<number, number>(); // pointer -> the x it holds
  const at = new Map<number, number>(); // pointer -> clientX
  over.addEventListener('pointerdown', (event) => {
    if (event.pointerType === 'mouse' && !event.shiftKey) return;
    fingers.set(event.pointerId, of.xAt(event.clientX));
    at.set(event.pointerId, event.clientX);
    if (event.pointerType === 'mouse') over.setPointerCapture(event.pointerId);
  });
  over.addEventListener('pointermove', (event) => {
    if (!fingers.has(event.pointerId)) return;
    at.set(event.pointerId, event.clientX);
    const held = [...fingers.values()];
    if (event.pointerType === 'mouse') of.zoom(moved(of.seen(), held[0] - of.xAt(event.clientX)));
    else if (held.length === 2) of.zoom(pinched(of, held, [...at.values()]));
  });
  const end = (event: PointerEvent) => {
    fingers.delete(event.pointerId);
    at.delete(event.pointerId);
  };
  over.addEventListener('pointerup', end);
  over.addEventListener('pointercancel', end);
}

// The range in which both fingers stand on the values that they took hold of.
function pinched(of: Gestured, held: readonly number[], clientX: readonly number[]): Range {
  const range = of.seen();
  const now = clientX.map(of.xAt);
  const factor = Math.abs(now[1] - now[0]) > 0 ? (held[1] - held[0]) / (now[1] - now[0]) : 1;
  if (!(factor > 0.05 && factor < 20)) return range;
  const from = held[0] - (now[0] - range.from) * factor;
  return { from, to: from + (range.to - range.from) * factor };
}
