// What a run of a trajectory would do, as the daemon says it, and the picture.
import { useMemo } from 'preact/hooks';
import { api } from '@/api/client';
import type { CheckTrajectoryResponse } from '@/api/gen/driftwise/v1/run_service_pb';
import { count, fixed, rangeText } from '@/format/numbers';
import { duration, secondsOf } from '@/format/time';
import { kindOf, splitChannel } from '@/format/units';
import { Plot } from '@/plot/plot';
import { Poses } from '@/poses/poses';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed, Warned } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { Verdict } from '@/ui/verdict';
import { bandText, estimatedEnd } from '@/trajectory/estimate';
import { useLimits, type CellLimits } from '@/trajectory/limits';
import { forceText, rangesOf, trajectoryRows, type TrajectoryRows } from '@/trajectory/parse';
import { lineSpec, sceneOf } from './scene';

export function useTrajectoryCheck(text: string) {
  return useAsked(text.trim() === '' ? undefined : text, (signal) => api.run().checkTrajectory({ trajectoryText: text }, { signal }));
}

export function TrajectoryCheck({ text, name, asked }: { text: string; name: string; asked: ReturnType<typeof useTrajectoryCheck> }) {
  const rows = useMemo(() => trajectoryRows(text), [text]);
  const limits = useLimits();
  const check = asked.value;
  return (
    <>
      {asked.failure && (
        <Panel title="It cannot be run"><Failed asked="Check the trajectory" failure={asked.failure} again={asked.failure.lost ? asked.again : undefined} /></Panel>
      )}
      {!check && !asked.failure && <Awaiting what="the daemon's check" />}
      <div class="trajectories-preview">
        {rows.rows.length > 0 && <Panel><Picture rows={rows} limits={limits.value} name={name} /></Panel>}
        {check && <Facts check={check} rows={rows} limits={limits.value} />}
      </div>
    </>
  );
}

function Picture({ rows, limits, name }: { rows: TrajectoryRows; limits: CellLimits | undefined; name: string }) {
  const title = name ? `Order of visit, ${name}` : 'Order of visit';
  const scene = useMemo(() => sceneOf(rows, limits?.axes ?? [], title), [rows, limits, title]);
  const spec = useMemo(() => lineSpec(rows, limits?.axes ?? [], title), [rows, limits, title]);
  return rows.coordinates.length < 2 ? <Plot spec={spec} height={320} /> : <Poses scene={scene} file={name || 'trajectory'} />;
}

function Facts({ check, rows, limits }: { check: CheckTrajectoryResponse; rows: TrajectoryRows; limits: CellLimits | undefined }) {
  const seconds = secondsOf(check.estimatedDuration) ?? 0;
  const forces = forceText(rows);
  return (
    <div class="stack">
      <Panel title="What a run of it would do">
        <dl class="facts">
          <dt>points</dt><dd>{count(check.rowCount)}: {count(check.calibrationCount)} calibration, {count(check.validationCount)} validation; {count(check.zeroCount)} of them returns to zero</dd>
          <dt>lines</dt><dd>{count(check.lineCount)}</dd>
          <dt>coordinates</dt><dd>{check.coordinates.map((channel) => splitChannel(channel).symbol).join(', ')}, {kindOf(check.coordinates[0] ?? '') === 'motor' ? 'motor coordinates' : 'wanted poses'}</dd>
          <dt>takes about</dt><dd>{duration(seconds)}{check.estimatedBand && ` (${bandText(check.estimatedBand)})`}{estimatedEnd(seconds) && `; begun now, ready ${estimatedEnd(seconds)}`}</dd>
          {forces && (<><dt>forces</dt><dd>{forces}; {limits?.actuator ? 'the load actuator changes them' : 'a person hangs the weights: the run waits'}</dd></>)}
        </dl>
      </Panel>
      <LimitsPanel rows={rows} limits={limits} />
      <Panel title="Remarks before it runs">
        {check.warnings.length === 0 ? <Verdict kind="good">nothing found</Verdict> : <div class="stack">{check.warnings.map((warning) => <Warned key={warning}>{warning}</Warned>)}</div>}
      </Panel>
    </div>
  );
}

function LimitsPanel({ rows, limits }: { rows: TrajectoryRows; limits: CellLimits | undefined }) {
  const ranges = rangesOf(rows);
  return (
    <Panel title="Limits">
      <table>
        <thead><tr><th scope="col">coordinate</th><th scope="col" class="number">from, mm</th><th scope="col" class="number">to, mm</th><th scope="col">soft limits</th></tr></thead>
        <tbody>
          {ranges.map((range) => {
            const limit = limits?.axes.find((one) => one.channel === range.channel);
            const inside = limit && range.low >= limit.min && range.high <= limit.max;
            return (
              <tr key={range.channel}>
                <td>{range.symbol}</td>
                <td class="number">{fixed(range.low, 3)}</td>
                <td class="number">{fixed(range.high, 3)}</td>
                <td>{limit ? <Verdict kind={inside ? 'good' : 'bad'}>{`${rangeText(limit.min, limit.max, 2)} mm`}</Verdict> : <span class="muted">of the motors: checked against the target of each pose</span>}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </Panel>
  );
}
