// A plot as plain data: the same description is drawn by uPlot on the page, written as SVG for papers and as CSV.
// Units are the data's; nothing here converts.

export type Colour = 'q1' | 'q2' | 'q3' | 's4' | 's5' | 's6' | 'muted' | 'bad' | 'good' | 'idle';

// Calibration: filled circle; validation: open diamond; zero: small plus; rejected: open ring in `bad`; dot: small
// filled circle without meaning.
export type Marker = 'calibration' | 'validation' | 'zero' | 'rejected' | 'dot';

export interface PlotSeries {
  name: string; // in the legend and as the CSV column: "q1"
  unit: string; // "nm"
  colour: Colour;
  x: ArrayLike<number>; // series that share their instants should share the very array
  y: ArrayLike<number>; // NaN: a gap, never bridged
  min?: ArrayLike<number>; // of decimated data: fill between min and max under the mean
  max?: ArrayLike<number>;
  draw?: 'line' | 'dashed' | 'markers' | 'steps'; // absent: line
  marker?: Marker; // with markers; absent: dot
  axis?: 'left' | 'right';
  digits?: number; // in legend and table; absent: by the unit
  holds?: number; // in the unit of x, of a channel: a value stands for so long, beyond it nothing is known; absent: no limit
  ofPoints?: boolean; // a value for each point of a run: the line ends at a stop or pause
  quiet?: boolean; // one of many: thin, and grey while another one is pointed at in the key
  dash?: readonly number[]; // px, of a line: tells many of few colours apart
  // Parallel to y, with markers: which of the page's things a point is (row of the run), so that it can be chosen.
  keys?: ArrayLike<number>;
}

export interface PlotBand {
  from: number;
  to: number; // in the unit of the left axis
  colour: Colour;
  label: string; // "U90"
}

export interface PlotLimit {
  at: number;
  label: string; // "limit 20 nm"
  axis?: 'left' | 'right';
}

// An instant that explains a step: a vertical line.
export interface PlotMark {
  at: number; // in the unit of x
  kind: 'force' | 'stop' | 'resume' | 'restart' | 'note';
  label: string; // "force 0 to 0.768 N"
}

export interface PlotSpan {
  from: number;
  to: number; // in the unit of x
  kind: 'gap' | 'chosen';
}

export interface PlotSpec {
  title: string;
  // In words, above the plot: "nm against hours since start". The unit of y stands first.
  what: string;
  x: {
    label: string; // CSV column: "time_h"
    unit: string; // "h"
    startMs?: number; // x is hours since this instant: the legend then shows clock time
    sinceFirstRow?: boolean; // x is hours since the first row of a data set: the page gives the marks of its runs
    whole?: boolean; // counts: ticks at whole numbers only
    clock?: boolean; // ticks as time of day; startMs is then a local midnight
    low?: number; // at least this range is shown, whatever was measured in it
    high?: number;
  };
  y: {
    unit: string;
    symmetric?: boolean; // residuals: about zero
    zero?: boolean; // absent: true; false where zero is far from meaning anything (temperatures)
    low?: number; // at least this range is shown, so that several plots share one scale
    high?: number;
  };
  right?: { unit: string; low?: number; high?: number };
  series: readonly PlotSeries[];
  bands?: readonly PlotBand[];
  limits?: readonly PlotLimit[];
  spans?: readonly PlotSpan[];
  marks?: readonly PlotMark[]; // absent: those of the page around it
  deviation?: boolean; // many channels: shown as deviation from the start, as values when asked
  why?: string; // shown instead of an empty plot: why there is nothing
  note?: string; // "1 px = 135 s"
  file?: string; // start of exported file names: "run-17-zero"
  head?: readonly string[]; // further `# key: value` lines of the CSV
}
