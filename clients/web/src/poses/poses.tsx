// Poses in 3-D: turn by dragging or with the arrow keys, zoom with + and -, choose by pressing a pose. Drawn on a canvas
// only when something changed; the same shapes are written as SVG, the poses as CSV.
import type { Signal } from '@preact/signals';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { fixed, rangeText, significant } from '@/format/numbers';
import { palette } from '@/plot/palette';
import { Button } from '@/ui/button';
import { download } from '@/ui/download';
import { homeCamera, turned, zoomed, type Camera } from './camera';
import { paintShapes } from './canvas';
import { mix } from './colours';
import { posesCsv } from './csv';
import { colourRange, type PoseScene } from './pose';
import { poseAt, shapesOf } from './shapes';
import { setWords } from './set';
import { shapesSvg } from './svg';
import './poses.css';

const keyTurns: Record<string, (camera: Camera) => Camera> = {
  ArrowLeft: (c) => turned(c, -0.1, 0),
  ArrowRight: (c) => turned(c, 0.1, 0),
  ArrowUp: (c) => turned(c, 0, 0.1),
  ArrowDown: (c) => turned(c, 0, -0.1),
  '+': (c) => zoomed(c, 1.25),
  '-': (c) => zoomed(c, 0.8),
  '0': () => homeCamera,
};

export function Poses({ scene, height: wanted = 440, chosen, onPick, file = 'poses' }: {
  scene: PoseScene;
  height?: number; // px
  chosen?: Signal<number | undefined>; // key of the pose that is marked everywhere
  onPick?: (key: number) => void;
  file?: string; // start of exported file names
}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [camera, setCamera] = useState(homeCamera);
  const [width, setWidth] = useState(600);
  const [upTo, setUpTo] = useState<number>();
  const height = Math.min(wanted, Math.round(width * 0.9));
  const colours = palette();
  const seen = { width, height, upTo: upTo ?? scene.poses.length, chosen: chosen?.value };
  const shapes = useMemo(() => shapesOf(scene, camera, seen, colours), [scene, camera, width, height, seen.upTo, seen.chosen, colours]);

  useEffect(() => {
    const watch = new ResizeObserver(([entry]) => setWidth(Math.max(240, Math.round(entry.contentRect.width))));
    watch.observe(canvas.current!.parentElement!);
    return () => watch.disconnect();
  }, []);
  useEffect(() => {
    const frame = requestAnimationFrame(() => {
      const element = canvas.current;
      const context = element?.getContext('2d');
      if (!element || !context) return;
      const ratio = devicePixelRatio || 1;
      element.width = width * ratio;
      element.height = height * ratio;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      paintShapes(context, shapes, getComputedStyle(element).fontFamily);
    });
    return () => cancelAnimationFrame(frame);
  }, [shapes, width, height]);

  const drag = useDrag((dx, dy) => setCamera((c) => turned(c, dx * 0.01, dy * 0.01)), (x, y) => {
    const key = poseAt(shapes, x, y);
    if (key !== undefined) onPick?.(key);
  });
  const last = upTo === undefined ? undefined : scene.poses[upTo - 1];
  return (
    <figure class="poses">
      <figcaption class="panel-head">
        <h2>{scene.title}</h2>
        <div class="poses-tools">
          <Button small onPress={() => setCamera(homeCamera)}>Turn back</Button>
          <Button small label="Picture as SVG" onPress={() => download(`${file}.svg`, shapesSvg(shapes, width, height, scene.title, colours.panel), 'image/svg+xml')}>SVG</Button>
          <Button small label="Picture as PNG" onPress={() => canvas.current?.toBlob((blob) => blob && download(`${file}.png`, blob, 'image/png'))}>PNG</Button>
          <Button small label="Poses as CSV" onPress={() => download(`${file}.csv`, posesCsv(scene), 'text/csv')}>CSV</Button>
        </div>
      </figcaption>
      <Legend scene={scene} />
      <div class="poses-stage">
        <canvas
          ref={canvas}
          class="poses-canvas"
          role="application"
          aria-roledescription="picture that can be turned"
          aria-label={`${scene.title}: ${textOf(scene)}. Arrow keys turn it, plus and minus zoom, 0 turns back.`}
          tabIndex={0}
          height={height}
          onKeyDown={(event) => {
            const turn = keyTurns[event.key];
            if (!turn || event.ctrlKey || event.metaKey || event.altKey) return;
            event.preventDefault();
            setCamera(turn);
          }}
          onWheel={(event) => {
            if (!event.ctrlKey) return;
            event.preventDefault();
            setCamera((c) => zoomed(c, event.deltaY < 0 ? 1.1 : 1 / 1.1));
          }}
          {...drag}
        />
      </div>
      <p class="note muted">{textOf(scene)}. Drag to turn.</p>
      {scene.path && scene.poses.length > 1 && (
        <label class="poses-order">
          <span class="note muted">order of visit</span>
          <input
            type="range"
            min={1}
            max={scene.poses.length}
            value={seen.upTo}
            aria-valuetext={last ? `pose ${upTo} of ${scene.poses.length}` : 'all poses'}
            onInput={(event) => {
              const n = Number(event.currentTarget.value);
              setUpTo(n >= scene.poses.length ? undefined : n);
            }}
          />
          <span class="note poses-order-text">
            {last
              ? `${upTo} of ${scene.poses.length}: ${scene.axes.map((axis, i) => `${axis.name} ${fixed(last.at[i], 3)}`).join(', ')} ${scene.axes[0].unit}, ${setWords[last.set]}`
              : `all ${scene.poses.length}`}
          </span>
        </label>
      )}
    </figure>
  );
}

function Legend({ scene }: { scene: PoseScene }) {
  const colours = palette();
  const [low, high] = colourRange(scene);
  const sets = new Set(scene.poses.map((pose) => pose.set));
  const text = (value: number) => (scene.colour.by === 'order' ? fixed(value) : significant(value, 3));
  const stops = [0, 0.5, 1].map((share) => mix(mix(colours.panel, colours.q1, 0.3), colours.q1, share));
  return (
    <div class="poses-legend note">
      {sets.has('calibration') && <span><svg width="12" height="12" aria-hidden="true"><circle cx="6" cy="6" r="4" fill={colours.q1} /></svg> calibration</span>}
      {sets.has('validation') && <span><svg width="12" height="12" aria-hidden="true"><path d="M6 1 11 6 6 11 1 6Z" fill="none" stroke={colours.q1} stroke-width="1.5" /></svg> validation</span>}
      {sets.has('zero') && <span><svg width="12" height="12" aria-hidden="true"><path d="M1 6H11M6 1V11" stroke={colours.q1} stroke-width="1.5" /></svg> return to zero</span>}
      {sets.has('rejected') && <span><svg width="12" height="12" aria-hidden="true"><circle cx="6" cy="6" r="4.5" fill="none" stroke={colours.bad} stroke-width="1.5" /></svg> given up</span>}
      <span class="poses-scale">
        {scene.colour.what}{scene.colour.unit && `, ${scene.colour.unit}`}: {text(low)}
        <svg width="96" height="10" aria-hidden="true">
          <defs><linearGradient id="poses-ramp">{stops.map((colour, i) => <stop offset={i / 2} stop-color={colour} />)}</linearGradient></defs>
          <rect width="96" height="10" rx="2" fill="url(#poses-ramp)" />
        </svg>
        {text(high)}
      </span>
    </div>
  );
}

function textOf(scene: PoseScene): string {
  const box = scene.axes
    .filter((axis) => axis.high > axis.low)
    .map((axis) => `${axis.name} ${rangeText(axis.low, axis.high, 2)} ${axis.unit}`)
    .join(', ');
  return `${scene.poses.length} poses; box: ${scene.box}, ${box}`;
}

// A drag turns; a press without one chooses. One finger on a phone scrolls the page, so a touch turns only sideways.
function useDrag(onTurn: (dx: number, dy: number) => void, onPress: (x: number, y: number) => void) {
  const from = useRef<{ x: number; y: number; far: number } | undefined>(undefined);
  return {
    onPointerDown(event: PointerEvent) {
      from.current = { x: event.clientX, y: event.clientY, far: 0 };
      (event.currentTarget as Element).setPointerCapture(event.pointerId);
    },
    onPointerMove(event: PointerEvent) {
      const start = from.current;
      if (!start) return;
      const [dx, dy] = [event.clientX - start.x, event.clientY - start.y];
      from.current = { x: event.clientX, y: event.clientY, far: start.far + Math.abs(dx) + Math.abs(dy) };
      if (from.current.far > 4) onTurn(dx, event.pointerType === 'touch' ? 0 : dy);
    },
    onPointerUp(event: PointerEvent) {
      if (from.current && from.current.far <= 4) {
        const box = (event.currentTarget as Element).getBoundingClientRect();
        onPress(event.clientX - box.left, event.clientY - box.top);
      }
      from.current = undefined;
    },
    onPointerCancel() {
      from.current = undefined;
    },
  };
}
