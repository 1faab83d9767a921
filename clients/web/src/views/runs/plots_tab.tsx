// The run over time: spread, zero, temperatures, force. All share time axis, cursor and zoom (in the address, UTC); a point
// chosen anywhere is marked everywhere.
import { useSignal, type Signal } from '@preact/signals';
import { useEffect, useMemo, useRef } from 'preact/hooks';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { query, setQuery } from '@/app/router';
import { fromUtc, ms, utc } from '@/format/time';
import { isAngle, isLength, splitChannel, unitSign } from '@/format/units';
import { layout } from '@/live/channels';
import { usePointColumns, type RunPoints } from '@/live/points';
import { cellTimeMs } from '@/live/state';
import { seriesOfTrack } from '@/parts/history_plot';
import { isImported, isOver, ruleOf } from '@/parts/run_words';
import { spreadPlot } from '@/parts/spread_plot';
import { airOf, lengthsOf, zeroDrift, zeroPlot } from '@/parts/zero_plot';
import { lookOf } from '@/plot/many';
import { Plot, type Range } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { ChannelChoice, chosenChannels } from './channel_choice';
import { Closures } from './closures';
import { noReadings, tracksOfPoints, withoutClock } from './imported';
import { spanOf, useTracks, type ZoomedTracks } from './use_tracks';

// The zoom lives in the address: from and to in UTC.
function useZoom(startMs: number): Signal<Range | undefined> {
  const hours = (text: string | undefined) => {
    const at = fromUtc(text);
    return at === undefined ? undefined : (at - startMs) / 3600e3;
  };
  const asked = (): Range | undefined => {
    const from = hours(query('from'));
    const to = hours(query('to'));
    return from === undefined || to === undefined || !(to > from) ? undefined : { from, to };
  };
  const range = useSignal<Range | undefined>(asked());
  const written = useRef(`${query('from')} ${query('to')}`);
  const inAddress = `${query('from')} ${query('to')}`;
  useEffect(() => {
    if (inAddress !== written.current) range.value = asked(); // back, forward, or a link
    written.current = inAddress;
  }, [inAddress]);
  const now = range.value;
  useEffect(() => {
    const timer = setTimeout(() => {
      const text = (x: number) => utc(Math.round(startMs + x * 3600e3));
      const changes = now ? { from: text(now.from), to: text(now.to) } : { from: undefined, to: undefined };
      written.current = `${changes.from} ${changes.to}`;
      setQuery(changes);
    }, 300);
    return () => clearTimeout(timer);
  }, [now]);
  return range;
}

function titleOf(unit: string): string {
  if (unit === 'degC' || unit === 'K') return 'Temperatures';
  if (unit === 'N') return 'Force';
  return isLength(unit) ? 'Lengths' : isAngle(unit) ? 'Tilts' : 'Record';
}

function recordPlot(unit: string, names: readonly string[], tracks: ZoomedTracks, startMs: number, runId: bigint): PlotSpec {
  const many = names.length > 6;
  const what = titleOf(unit);
  return {
    title: what,
    what: `${unitSign(unit)} against hours since start`,
    x: { label: 'time_h', unit: 'h', startMs },
    y: { unit, zero: unit === 'N' ? undefined : false },
    deviation: many,
    series: names.map((name, i) => seriesOfTrack(tracks.of(name), startMs, { ...(unit === 'N' ? { colour: 's6' as const } : lookOf(i)), quiet: many, ...(unit === 'N' && { draw: 'steps' as const }) })),
    ...(tracks.bucketS >= 2 && { note: `1 px = ${Math.round(tracks.bucketS)} s` }),
    ...(tracks.waiting && { why: 'Waiting for the record …' }),
    file: `run-${runId}-${what.toLowerCase()}`,
  };
}

export function PlotsTab({ run, rulesJson, points, chosen, onPick }: {
  run: Run; rulesJson: string; points: RunPoints; chosen: Signal<number | undefined>; onPick: (row: number) => void;
}) {
  const columns = usePointColumns(points.points, ms(run.startTime));
  const { startMs } = columns;
  const imported = isImported(run);
  const limitNm = ruleOf(rulesJson, 'max_spread_nm');
  const live = !isOver(run);
  const range = useZoom(startMs);
  const spread = useMemo(() => ({ ...spreadPlot(points.attempts, startMs, limitNm, imported ? noReadings : undefined), file: `run-${run.id}-spread` }), [points.attempts, startMs, limitNm, imported]);
  const zero = useMemo(() => {
    const air = airOf(columns.channels);
    const drift = zeroDrift(points.points, startMs, lengthsOf(columns.channels));
    const spec = { ...zeroPlot(drift, startMs, air ? { name: air, x: columns.hours, y: columns.of(air) } : undefined), file: `run-${run.id}-zero` };
    return imported ? withoutClock(spec, columns) : spec;
  }, [columns, imported]);

  // The cell's channels are no channels of a file, even under the same name.
  const all = imported ? columns.channels : [...new Set([...layout.value.map((one) => one.name), ...columns.channels])];
  const names = chosenChannels(all);
  const span = imported ? undefined : spanOf(run, points.points, cellTimeMs.peek());
  const recorded = useTracks(names, startMs, span, range, live);
  const ofPoints = useMemo(() => tracksOfPoints(columns), [columns]);
  const tracks = imported ? ofPoints : recorded;
  const units = [...new Set(names.map((name) => splitChannel(name).unit))];
  const specs = useMemo(
    () => units.map((unit) => {
      const spec = recordPlot(unit, names.filter((name) => splitChannel(name).unit === unit), tracks, startMs, run.id);
      return imported ? { ...withoutClock(spec, columns), note: 'imported: values of its points, no readings on record' } : spec;
    }),
    [tracks, names.join(), imported],
  );
  const shared = { range, live, chosen, onPick, group: `run-${run.id}`, height: 220 };
  return (
    <>
      <div class="columns">
        <Panel><Plot spec={spread} {...shared} /></Panel>
        <Panel><Plot spec={zero} {...shared} /></Panel>
        {specs.map((spec) => <Panel key={spec.y.unit}><Plot spec={spec} {...shared} /></Panel>)}
      </div>
      {tracks.failure && <Failed asked="Read the record" failure={tracks.failure} again={tracks.again} />}
      <ChannelChoice all={all} chosen={names} />
      <Closures run={run} />
    </>
  );
}
