// One animation frame for everything that moves: numbers and plots at most four times a second, plots as much less often as there
// are more than twelve of them: a frame is what a page costs, whatever changes in it, and nobody reads a number faster. A hidden
// page gets no frames, so it draws nothing; what came meanwhile is painted when it is looked at again.
import { signal } from '@preact/signals';
import { paintChannels } from './channels';

const numbersEveryMs = 250;
const plotsEveryMs = 250;
const fewPlots = 12;

export const plotTick = signal(0); // live plots redraw when it changes

let before = (): void => undefined;

// What is done first within the frame: the stream's news are taken, so that whatever they change is painted with the numbers.
export function paintFirst(what: () => void): void {
  before = what;
}

let livePlots = 0;
let asked = false;

// Returns what ends it.
export function countLivePlot(): () => void {
  livePlots++;
  return () => void livePlots--;
}
let numbersAt = 0;
let plotsAt = 0;

function paint(now: number): void {
  asked = false;
  numbersAt = now;
  before();
  paintChannels();
  if (now - plotsAt >= plotsEveryMs * Math.max(1, livePlots / fewPlots) - 20) {
    plotsAt = now;
    plotTick.value++;
  }
}

export function askForPaint(): void {
  if (asked) return;
  asked = true;
  const wait = numbersAt + numbersEveryMs - performance.now();
  if (wait <= 0) requestAnimationFrame(paint);
  else setTimeout(() => requestAnimationFrame(paint), wait);
}
