// Draws a PlotSpec: title, legend, unit in words, the drawing, and its tools. Zoom, cursor and the chosen point can be shared
// with other plots.
import { useSignal, type Signal } from '@preact/signals';
import { useContext, useEffect, useId, useLayoutEffect, useMemo, useRef, useState } from 'preact/hooks';
import type uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import './plot.css';
import { printing } from '@/app/printing';
import { dark } from '@/app/theme';
import { countLivePlot, plotTick } from '@/live/paint';
import { nearest } from './aligned';
import { inOrder } from './in_order';
import { makePlot, redraw, seenRange, shapeOf, type Drawn } from './draw';
import { ExportMenu } from './export_menu';
import { followGestures, keyPressed, type Gestured } from './gestures';
import { Held } from './held';
import { pin, pinned, pinnedX } from './instant';
import { Legend } from './legend';
import { deviationFromStart } from './many';
import { RowMarks, TimeMarks, withTimeMarks } from './marks';
import { palette } from './palette';
import { PlotTable } from './plot_table';
import type { Range } from './ranges';
import type { PlotSpec } from './spec';
import { svgOf } from './svg';
import { inWords } from './values';

export type { Range } from './ranges';

export interface PlotProps {
  spec: PlotSpec;
  height?: number; // px of the drawing, 200 unless told
  group?: string; // plots of one group share the cursor
  range?: Signal<Range | undefined>; // shared zoom; undefined: everything (or live)
  live?: boolean; // follows now, unless zoomed: then it says "held"
  chosen?: Signal<number | undefined>; // key of the point that is marked everywhere
  onPick?: (key: number) => void; // a marker was chosen
  bare?: boolean; // without title and tools: small multiples
}

// The key of the marker nearest to a click, within 12 px.
function picked(u: uPlot, spec: PlotSpec, x: number, y: number): number | undefined {
  let best = 12;
  let key: number | undefined;
  for (const one of spec.series) {
    if (!one.keys) continue;
    const middle = nearest(one.x, u.posToVal(x, 'x'));
    for (let i = Math.max(0, middle - 50); i < Math.min(one.x.length, middle + 50); i++) {
      const scale = one.axis === 'right' ? 'r' : 'y';
      const far = Math.hypot(u.valToPos(one.x[i], 'x') - x, u.valToPos(one.y[i], scale) - y);
      if (far < best) [best, key] = [far, one.keys[i]];
    }
  }
  return key;
}

// The plot in words, anew at most every five seconds: nobody is read a label that changes while it is read.
function useWords(drawn: Drawn): string {
  const kept = useRef({ words: '', atMs: -Infinity, key: '' });
  const now = performance.now();
  const key = `${drawn.spec.title} ${drawn.range?.from} ${drawn.range?.to} ${drawn.spec.series.length}`;
  if (key !== kept.current.key || now - kept.current.atMs > 5000) kept.current = { words: inWords(drawn.spec, seenRange(drawn)), atMs: now, key };
  return kept.current.words;
}

export function Plot(props: PlotProps) {
  const { height = 200, group, live, onPick, bare } = props;
  const own = useSignal<Range | undefined>(undefined);
  const range = props.range ?? own;
  const id = useId();
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | undefined>(undefined);
  const [cursor, setCursor] = useState<number>();
  const [pointed, setPointed] = useState<number>();
  const [table, setTable] = useState(false);
  const [values, setValues] = useState(false); // of many channels: not their deviation
  const marks = useContext(TimeMarks);
  const ofRows = useContext(RowMarks);
  const deviates = props.spec.deviation === true && !values;
  const spec = useMemo(() => {
    const ordered = { ...props.spec, series: props.spec.series.map(inOrder) };
    return withTimeMarks(deviates ? deviationFromStart(ordered) : ordered, marks, ofRows);
  }, [props.spec, marks, ofRows, deviates]);
  const drawn: Drawn = { spec, range: range.value, chosen: props.chosen?.value, pointed, colours: palette(), instant: undefined };
  drawn.instant = pinnedX(spec, seenRange(drawn));
  const words = useWords(drawn);
  const latest = useRef(drawn);
  latest.current = drawn;
  const pick = useRef(onPick);
  pick.current = onPick;
  const empty = spec.why !== undefined || spec.series.every((one) => one.x.length === 0);
  const seen = useSignal(true);
  const tick = live && seen.value ? plotTick.value : 0;
  useEffect(() => (live ? countLivePlot() : undefined), [live]);

  const gestured: Gestured = {
    seen: () => seenRange(latest.current),
    zoom: (to) => (range.value = to),
    xAt: (clientX) => {
      const u = plot.current!;
      return u.posToVal(clientX - u.over.getBoundingClientRect().left, 'x');
    },
  };

  // A click on the line that stands lets it go.
  const pinAt = (x: number) => {
    const { spec: of, instant } = latest.current;
    if (instant !== undefined && Math.abs(plot.current!.valToPos(instant, 'x') - x) < 5) pinned.value = undefined;
    else pin(of, plot.current!.posToVal(x, 'x'), seenRange(latest.current));
  };

  const shape = shapeOf(spec);
  useEffect(() => {
    if (empty || table || !box.current) return;
    const root = box.current;
    const u = makePlot(root, () => latest.current, {
      zoom: gestured.zoom,
      cursor: setCursor,
      click: (x, y) => {
        const key = picked(plot.current!, latest.current.spec, x, y);
        if (key !== undefined) pick.current?.(key);
        else pinAt(x);
      },
    }, { width: Math.max(120, root.clientWidth), height }, group);
    plot.current = u;
    followGestures(u.over, gestured);
    const sized = new ResizeObserver(() => root.clientWidth > 0 && u.setSize({ width: root.clientWidth, height }));
    sized.observe(root);
    // What nobody sees is not painted; it catches up when it scrolls into view.
    const watched = new IntersectionObserver(([entry]) => {
      if (entry.isIntersecting && !seen.peek() && plot.current) redraw(plot.current, latest.current);
      seen.value = entry.isIntersecting;
    }, { rootMargin: '100px' });
    watched.observe(root);
    return () => {
      sized.disconnect();
      watched.disconnect();
      u.destroy();
      plot.current = undefined;
    };
  }, [shape, dark.value, height, group, empty, table]);

  // In the frame that brought the numbers: an ordinary effect runs after it, and each picture would cost a frame of its own. A live
  // plot waits for the tick of all of them with what came in between.
  const shown = useRef<readonly unknown[]>([]);
  const wish = [spec, range.value, props.chosen?.value, pointed, drawn.instant];
  useLayoutEffect(() => {
    if (!plot.current || !seen.peek() || wish.every((one, at) => one === shown.current[at])) return;
    shown.current = wish;
    redraw(plot.current, latest.current);
  }, live ? [tick, ...wish.slice(1)] : wish);

  return (
    <figure class={`plot${bare ? ' plot-bare' : ''}`}>
      <div class="plot-head">
        <figcaption id={id}>{spec.title}</figcaption>
        {!bare && !empty && props.spec.deviation && (
          <span class="plot-tools"><button type="button" class="tool" aria-pressed={deviates} onClick={() => setValues(!values)}>Deviation from the start</button></span>
        )}
        {!bare && !empty && <ExportMenu spec={spec} range={gestured.seen} drawing={() => plot.current} table={table} onTable={() => setTable(!table)} />}
      </div>
      {!bare && <Legend spec={spec} cursor={cursor ?? drawn.instant} pointed={pointed} onPoint={setPointed} />}
      <p class="note muted plot-what">
        {spec.what}{spec.note && ` · ${spec.note}`}
        <Held spec={spec} range={range} live={live === true} />
      </p>
      {printing.value && !empty && <div class="plot-paper" dangerouslySetInnerHTML={{ __html: svgOf(spec, seenRange(drawn), 680, height + 100, id) }} />}
      {empty && <p class="plot-why muted">{spec.why ?? 'Nothing was measured in this range.'}</p>}
      {!empty && table && <PlotTable spec={spec} />}
      {!empty && !table && (
        <div
          ref={box}
          class="plot-box"
          role="group"
          tabIndex={0}
          aria-label={words}
          onKeyDown={(event) => {
            if (event.ctrlKey || event.metaKey) return;
            const { from, to } = gestured.seen();
            if (event.key === 'i') pin(spec, (from + to) / 2, { from, to });
            else if (keyPressed(event.key, gestured)) event.preventDefault();
          }}
        />
      )}
    </figure>
  );
}
