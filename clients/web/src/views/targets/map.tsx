// The correction, or its uncertainty, over a plane of the workspace. A press on the map takes that pose.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import type { Timestamp } from '@bufbuild/protobuf/wkt';
import { targetApi } from '@/api/target';
import { query, setQuery } from '@/app/router';
import { fixed, significant } from '@/format/numbers';
import { ms } from '@/format/time';
import { splitChannel } from '@/format/units';
import { palette } from '@/plot/palette';
import { Button } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { download } from '@/ui/download';
import { SymbolChoice } from '@/ui/choice';
import { MapLegend } from './map_legend';
import { mapCsv, mapOf, paintMap, placeOnMap, type MapPicture } from './map_picture';
import type { Pose, PoseField } from './pose';
import type { ComputedBy } from './use_target';

const countPerAxis = 41;
const room = 0.08; // of the domain, shown around it so that its edge is seen

export function CorrectionMap({ fields, pose, outputs, conditions, by }: {
  fields: readonly PoseField[];
  pose: Pose;
  outputs: readonly string[];
  conditions: Timestamp | undefined;
  by: ComputedBy;
}) {
  const lengths = fields.filter((field) => field.unit === 'mm');
  const planes = lengths.flatMap((a, i) => lengths.slice(i + 1).map((b) => `${a.symbol}–${b.symbol}`));
  const plane = planes.includes(query('plane') ?? '') ? query('plane')! : planes[0];
  const symbols = outputs.map((channel) => splitChannel(channel).symbol);
  const output = symbols.includes(query('out') ?? '') ? query('out')! : symbols[0];
  const what = query('map') === 'uncertainty' ? 'uncertainty' : 'correction';
  const [h, v] = plane ? plane.split('–').map((symbol) => lengths.find((field) => field.symbol === symbol)!) : [];
  // Temperatures move slowly: a map once in five minutes of the cell, and for every other pose or plane.
  const age = Math.floor((ms(conditions) ?? 0) / 300_000);
  const rest = pose.filter((one) => one.channel !== h?.channel && one.channel !== v?.channel);
  const subject = `${by.modelId} ${by.datum} ${plane} ${rest.map((one) => one.value).join()}`;
  const asked = useAsked(h && v && `map ${subject} ${age}`, (signal) => {
    const axis = (field: PoseField) => {
      const wide = (field.max - field.min) * room;
      return { channel: field.channel, from: field.min - wide, to: field.max + wide, count: countPerAxis };
    };
    return targetApi().mapTargets({ horizontal: axis(h!), vertical: axis(v!), pose: [...rest] }, { signal });
  });
  // The map of before stays while only its conditions are asked anew: of another plane or pose a press would take wrong coordinates.
  const last = useRef<{ subject: string; value: NonNullable<typeof asked.value> }>(undefined);
  if (asked.value) last.current = { subject, value: asked.value };
  const answer = asked.value ?? (asked.failure || last.current?.subject !== subject ? undefined : last.current.value);
  const picture = useMemo(() => answer && mapOf(answer, outputs[symbols.indexOf(output)], what), [answer, output, what]);
  if (!plane) return <Panel title="Over the workspace"><p class="muted">The model depends on one length only: there is no plane to show.</p></Panel>;
  return (
    <Panel title={`${what === 'correction' ? 'Correction' : 'Uncertainty (U90)'} of ${output} over ${plane.replace('–', ' and ')}`} actions={picture && <Files picture={picture} />}>
      <div class="row">
        <SymbolChoice symbols={planes} name="plane" label="Plane" />
        <SymbolChoice symbols={symbols} name="out" label="Output" />
        <SymbolChoice symbols={['correction', 'uncertainty']} name="map" label="Shown" />
      </div>
      {asked.failure && <Failed asked="Map the correction" failure={asked.failure} again={asked.again} />}
      {picture ? <Picture picture={picture} fields={[h, v]} pose={pose} /> : !asked.failure && <Awaiting what="the map" />}
      {rest.length > 0 && <p class="note muted">at {rest.map((one) => `${splitChannel(one.channel).symbol} ${fixed(one.value, 3)} ${splitChannel(one.channel).unit}`).join(', ')}; outlined: the domain the model was fitted in; grey: not reachable</p>}
    </Panel>
  );
}

function Picture({ picture, fields, pose }: { picture: MapPicture; fields: readonly PoseField[]; pose: Pose }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [pointed, setPointed] = useState<{ column: number; row: number }>();
  const [width, setWidth] = useState(480);
  const colours = palette();
  const height = Math.min(420, Math.round(width * 0.72));
  const chosen = fields.map((field) => pose.find((one) => one.channel === field.channel)?.value ?? NaN);
  useEffect(() => {
    const watch = new ResizeObserver(([entry]) => setWidth(Math.max(240, Math.round(entry.contentRect.width))));
    watch.observe(canvas.current!.parentElement!);
    return () => watch.disconnect();
  }, []);
  useEffect(() => {
    const element = canvas.current!;
    const context = element.getContext('2d');
    if (!context) return;
    const ratio = devicePixelRatio || 1;
    element.width = width * ratio;
    element.height = height * ratio;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    paintMap(context, picture, { width, height, chosen: [chosen[0], chosen[1]], fields, font: getComputedStyle(element).fontFamily }, colours);
  }, [picture, width, height, colours, chosen.join()]);
  const at = (event: MouseEvent) => {
    const box = canvas.current!.getBoundingClientRect();
    return placeOnMap(picture, width, height, event.clientX - box.left, event.clientY - box.top);
  };
  const shown = pointed && picture.values[pointed.row * picture.columns + pointed.column];
  return (
    <div class="targets-map">
      <canvas
        ref={canvas}
        height={height}
        role="img"
        aria-label={`${picture.title}: from ${significant(picture.low, 3)} to ${significant(picture.high, 3)} nm over the domain`}
        onMouseMove={(event) => setPointed(at(event))}
        onMouseLeave={() => setPointed(undefined)}
        onClick={(event) => {
          const spot = at(event);
          if (!spot) return;
          setQuery({ [fields[0].symbol]: spot.x.toFixed(3), [fields[1].symbol]: spot.y.toFixed(3) });
        }}
      />
      <MapLegend picture={picture} />
      <p class="note muted targets-pointed">
        {pointed && shown !== undefined
          ? `${fields[0].symbol} ${fixed(picture.x(pointed.column), 3)}, ${fields[1].symbol} ${fixed(picture.y(pointed.row), 3)} mm: ${fixed(shown, 1)} nm${picture.unreachable[pointed.row * picture.columns + pointed.column] ? ', not reachable' : ''}`
          : 'Point at a place for its value; press to take that pose.'}
      </p>
    </div>
  );
}

function Files({ picture }: { picture: MapPicture }) {
  return <Button small label="Map as CSV" onPress={() => download(`target-map-${picture.title.replaceAll(/[^a-z0-9]+/gi, '-')}.csv`, mapCsv(picture), 'text/csv')}>CSV</Button>;
}
