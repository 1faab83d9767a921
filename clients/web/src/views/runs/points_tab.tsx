// The points of a run: the poses in 3-D coloured by spread, beside them spread and zero over time, and a table with what became of
// each row. A point chosen in one of them is marked in all.
import type { Signal } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { Attempt_Verdict, PointSet, type Attempt, type Point, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { query, setQuery } from '@/app/router';
import { fixed, significant } from '@/format/numbers';
import { ms, secondsOf } from '@/format/time';
import { isAngle, kindOf, liveDigits, splitChannel, unitSign } from '@/format/units';
import { usePointColumns, valueOf, type RunPoints } from '@/live/points';
import { isImported, isOver, ruleOf } from '@/parts/run_words';
import { spreadPlot } from '@/parts/spread_plot';
import { lengthsOf, zeroDrift, zeroPlot } from '@/parts/zero_plot';
import { Plot } from '@/plot/plot';
import { Poses } from '@/poses/poses';
import { Panel } from '@/ui/panel';
import { Empty } from '@/ui/states';
import { Table, type Column } from '@/ui/table';
import { Verdict } from '@/ui/verdict';
import { noReadings, withoutClock } from './imported';
import { sceneOfPoints } from './scene';

export interface RunRow {
  row: number;
  point: Point | undefined;
  attempts: Attempt[];
}

// One entry per row of the plan that anything happened to, in order of the plan; then the passages, whose numbers count on.
export function rowsOf({ points, passages, attempts }: RunPoints): RunRow[] {
  const rows = new Map<number, RunRow>();
  const at = (row: number): RunRow => {
    const found = rows.get(row) ?? { row, point: undefined, attempts: [] };
    rows.set(row, found);
    return found;
  };
  for (const attempt of attempts) at(Number(attempt.row)).attempts.push(attempt);
  for (const point of [...points, ...passages]) at(Number(point.row)).point = point;
  return [...rows.values()].sort((a, b) => a.row - b.row);
}

const verdictWords: Record<Attempt_Verdict, string> = {
  [Attempt_Verdict.UNSPECIFIED]: 'unknown',
  [Attempt_Verdict.ACCEPTED]: 'accepted',
  [Attempt_Verdict.REREAD]: 'read again',
  [Attempt_Verdict.REAPPROACH]: 'approached again',
  [Attempt_Verdict.REQUEUED]: 'put off',
  [Attempt_Verdict.GIVEN_UP]: 'given up',
  [Attempt_Verdict.INTERRUPTED]: 'interrupted',
};

const setOf = (point: Point): string => (point.passage ? '↷ passage' : point.zero ? '+ zero' : point.set === PointSet.VALIDATION ? '◇ validation' : '● calibration');

const spreadOf = ({ attempts }: RunRow): number => attempts.filter((one) => one.spreadNm !== undefined).pop()?.spreadNm ?? NaN;

function Outcome({ of }: { of: RunRow }) {
  const last = of.attempts[of.attempts.length - 1]?.verdict;
  if (of.point?.passage) return <Verdict kind="good">beside the plan</Verdict>;
  if (of.point) return <Verdict kind={of.attempts.length > 1 ? 'extended' : 'good'}>{of.attempts.length > 1 ? `accepted, try ${of.attempts.length}` : 'accepted'}</Verdict>;
  return <Verdict kind={last === Attempt_Verdict.GIVEN_UP ? 'bad' : 'warn'}>{verdictWords[last ?? Attempt_Verdict.UNSPECIFIED]}</Verdict>;
}

const reasons = (of: RunRow): string => of.attempts.filter((one) => one.reason !== '').map((one) => one.reason).join('; ');

const shows: readonly [string, string, (row: RunRow) => boolean][] = [
  ['', 'all', () => true],
  ['again', 'measured again', (row) => row.attempts.length > 1],
  ['bad', 'not accepted', (row) => row.point === undefined],
  ['zero', 'returns to zero', (row) => row.point?.zero === true],
  ['passages', 'passages', (row) => row.point?.passage === true],
];

export function PointsTab({ run, rulesJson, points, chosen, onPick }: {
  run: Run; rulesJson: string; points: RunPoints; chosen: Signal<number | undefined>; onPick: (row: number) => void;
}) {
  const rows = useMemo(() => rowsOf(points), [points]);
  const show = shows.find(([id]) => id === (query('show') ?? '')) ?? shows[0];
  const shown = useMemo(() => rows.filter(show[2]), [rows, show]);
  const scene = useMemo(() => sceneOfPoints(points), [points]);
  const channels = points.points[0]?.values.map((one) => one.channel) ?? [];
  const pose = [...lengthsOf(channels), ...channels.filter((name) => kindOf(name) === 'tilt' && isAngle(splitChannel(name).unit)).sort()];
  const timed = usePointColumns(points.points, ms(run.startTime));
  const limitNm = ruleOf(rulesJson, 'max_spread_nm');
  const imported = isImported(run);
  const spread = useMemo(() => ({ ...spreadPlot(points.attempts, timed.startMs, limitNm, imported ? noReadings : undefined), file: `run-${run.id}-spread` }), [points.attempts, timed.startMs, limitNm, imported]);
  const zero = useMemo(() => {
    const spec = { ...zeroPlot(zeroDrift(points.points, timed.startMs, lengthsOf(timed.channels)), timed.startMs), file: `run-${run.id}-zero` };
    return imported ? withoutClock(spec, timed) : spec;
  }, [timed, imported]);
  const shared = { live: !isOver(run), chosen, onPick, group: `points-${run.id}`, height: 172 };
  const columns: Column<RunRow>[] = [
    { title: 'row', number: true, of: ({ row }) => <button type="button" class="link" onClick={(event) => { event.stopPropagation(); onPick(row); }}>{row}</button>, sort: ({ row }) => row },
    { title: 'line', number: true, of: ({ point }) => (point ? String(point.line) : ''), sort: ({ point }) => Number(point?.line ?? -1) },
    { title: 'set', of: ({ point }) => (point ? setOf(point) : ''), sort: ({ point }) => (point ? setOf(point) : '') },
    ...pose.map((channel): Column<RunRow> => ({
      title: `${splitChannel(channel).symbol}, ${unitSign(splitChannel(channel).unit)}`, number: true,
      of: ({ point }) => fixed(point && valueOf(point, channel), liveDigits(splitChannel(channel).unit)),
      sort: ({ point }) => (point ? valueOf(point, channel) : 0),
    })),
    { title: 'spread, nm', number: true, of: (row) => significant(spreadOf(row)), sort: (row) => spreadOf(row) || 0 },
    { title: 'dwell, s', number: true, of: ({ point }) => fixed(secondsOf(point?.dwellDuration), 1), sort: ({ point }) => secondsOf(point?.dwellDuration) ?? 0 },
    { title: 'verdict', of: (row) => <Outcome of={row} />, sort: (row) => row.attempts.length },
    { title: 'why', of: (row) => <span class="note">{reasons(row)}</span> },
  ];
  if (rows.length === 0) return <Panel><Empty>No point of run {String(run.id)} has been measured yet.</Empty></Panel>;
  return (
    <>
      <div class="columns">
        {scene && <Panel><Poses scene={scene} chosen={chosen} onPick={onPick} height={420} file={`run-${run.id}-poses`} /></Panel>}
        <Panel class="stack"><Plot spec={spread} {...shared} /><Plot spec={zero} {...shared} /></Panel>
      </div>
      <Panel
        title={`${shown.length} of ${rows.length} rows`}
        actions={
          <label class="row note">
            <span class="muted">show</span>
            <select class="input input-small" value={show[0]} onChange={(event) => setQuery({ show: event.currentTarget.value })}>
              {shows.map(([id, words]) => <option key={id} value={id}>{words}</option>)}
            </select>
          </label>
        }
      >
        <Table caption={`Points of run ${run.id}`} columns={columns} rows={shown} keyOf={({ row }) => row} page={50} rowClass={({ row }) => (row === chosen.value ? 'chosen' : undefined)} onRow={({ row }) => onPick(row)} />
      </Panel>
    </>
  );
}
