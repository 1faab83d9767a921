// The page of a run, from the data that stand in it.
import { useSignal } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { count, countRows, fixed, significant } from '@/format/numbers';
import { dateClock, duration } from '@/format/time';
import { robotOf, splitChannel, unitSign } from '@/format/units';
import { TimeMarks } from '@/plot/marks';
import { Plot } from '@/plot/plot';
import { Poses } from '@/poses/poses';
import { VerificationTable, type Figures } from '@/parts/verification';
import { figure, meanFigure, rowsInWords } from '@/ui/accuracy';
import { Panel } from '@/ui/panel';
import { Table, type Column } from '@/ui/table';
import { Mark, Verdict, type VerdictKind } from '@/ui/verdict';
import { residualSpecs } from '@/plot/residual_specs';
import type { Report, ReportAlarm, ReportDiagnosis, ReportEntry, ReportModel, ReportVerification } from './data';
import { storyOf } from './story';
import { forceSpec, marksOf, poseScene, spreads, spreadSpec, temperatureSpec, zeroSpec } from './specs';

const kinds: Record<string, VerdictKind> = { done: 'good', running: 'good', paused: 'idle', waiting: 'warn', aborted: 'warn', failed: 'bad' };
const at = (text: string | null) => (text ? dateClock(Date.parse(text)) : '–');

export function ReportPage({ report }: { report: Report }) {
  const { run } = report;
  const chosen = useSignal<number | undefined>(undefined);
  const scene = poseScene(report);
  const specs = [spreadSpec(report), zeroSpec(report), temperatureSpec(report), forceSpec(report)].filter((one) => one !== undefined);
  const marks = useMemo(() => marksOf(report), [report]);
  return (
    <main>
      <header class="view-title">
        <div>
          <h1>Run {run.id}{run.name && `, ${run.name}`}</h1>
          <p class="muted">cell {report.cell}; {run.trajectory}{run.operator && `; by ${run.operator}`}; written {at(report.made)} by Driftwise {report.version}</p>
        </div>
      </header>
      <Panel>
        <p class="state"><Mark kind={kinds[run.state] ?? 'idle'} size={32} /> {run.state[0].toUpperCase() + run.state.slice(1)}</p>
        {run.reason && <p class="muted">{run.reason}</p>}
        <dl class="facts">
          <dt>from, to</dt><dd>{at(run.start)} to {at(run.end)}{typeof run.elapsed_s === 'number' && `, ${duration(run.elapsed_s)}`}</dd>
          <dt>points</dt><dd>{count(run.accepted)} of {count(run.rows)} accepted, {count(run.given_up)} given up, {count(run.attempts)} attempts</dd>
          {run.metadata && Object.keys(run.metadata).length > 0 && <><dt>metadata</dt><dd>{Object.entries(run.metadata).map(([key, value]) => `${key}=${value}`).join(', ')}</dd></>}
          {run.compensation && <><dt>compensation</dt><dd>{run.compensation}</dd></>}
          <dt>restarts</dt><dd>{run.restarts === 0 ? 'none' : `a restarted daemon went on with it ${run.restarts === 1 ? 'once' : `${count(run.restarts)} times`}`}</dd>
          <dt>times in</dt><dd>UTC</dd>
          {report.certificates && report.certificates.length > 0 && <><dt>certificates</dt><dd>{report.certificates.map((one) => <div key={`${one.device} ${one.number}`}>{one.device}: {one.number}, {one.laboratory}, {one.date}{one.due && `, due ${one.due}${one.overdue ? ' (overdue)' : ''}`}</div>)}</dd></>}
          {report.record_head && <><dt>record</dt><dd>head of its chain <code class="hash">{report.record_head}</code>: <code>driftwise audit verify --head</code> finds a record written anew</dd></>}
          <dt>cell file</dt>
          <dd>
            {report.config_hash ? <code>{report.config_hash}</code> : 'none: its rows are a file\'s, imported'}
            {(report.configurations ?? []).slice(1).map((one) => <> ; from {one.from ? at(one.from) : 'an unknown time'} on <code>{one.hash}</code></>)}
          </dd>
          {(report.corrections ?? []).map((one) => (
            <>
              <dt>rests on</dt>
              <dd>
                correction {one.id}, in force since {at(one.since)}, accepted by {one.by}
                {one.changes.map((change) => `; ${change.channel} by up to ${significant(change.largest_nm, 3)} nm in ${countRows(change.rows)}`)}. The points below are as they were measured.
              </dd>
            </>
          ))}
        </dl>
      </Panel>
      {report.queue && report.queue.entries.length > 0 && <Panel title="Queue"><Entries entries={report.queue.entries} /></Panel>}
      <Panel title="Story"><Story report={report} /></Panel>
      {report.alarms.length > 0 && <Panel title="Alarms"><Alarms alarms={report.alarms} /></Panel>}
      {report.verification && <Panel title="Verification"><Verification of={report.verification} run={String(run.id)} /></Panel>}
      {scene && <Panel><Poses scene={scene} chosen={chosen} onPick={(key) => (chosen.value = key)} file={`run-${run.id}-poses`} /></Panel>}
      <TimeMarks.Provider value={marks}>
        <div class="columns">
          {specs.map((spec) => <Panel key={spec.title}><Plot spec={spec} height={220} chosen={chosen} onPick={(key) => (chosen.value = key)} /></Panel>)}
        </div>
      </TimeMarks.Provider>
      {report.models.map((model) => <Fitted key={model.id} model={model} />)}
      {report.diagnoses.map((one) => <Diagnosed key={one.id} of={one} />)}
      {report.closures && report.closures.length > 0 && <Panel title="Returns to zero"><Closures closures={report.closures} /></Panel>}
      <Panel title="Points"><Points report={report} /></Panel>
      {report.attempts.length > 0 && <Panel title="Measured again and given up"><Attempts report={report} /></Panel>}
      {report.events.length > 0 && <Panel title="Record"><Events report={report} /></Panel>}
    </main>
  );
}

function Entries({ entries }: { entries: readonly ReportEntry[] }) {
  return (
    <Table
      caption="The entry of this run, after those that it had to wait for"
      rows={entries}
      keyOf={(one) => one.id}
      columns={[
        { title: 'entry', number: true, of: (one) => `${one.id}` },
        { title: 'name', of: (one) => one.name },
        { title: 'run', of: (one) => (one.run === null ? '–' : `${one.run}`) },
        { title: 'state', of: (one) => <Verdict kind={kinds[one.run_state ?? ''] ?? 'idle'}>{one.run_state ?? one.state}</Verdict> },
        { title: 'from, to', of: (one) => <span class="nowrap">{at(one.begun)} to {at(one.ended)}</span> },
        { title: 'accepted', number: true, of: (one) => `${count(one.accepted ?? 0)} of ${count(one.rows ?? 0)}` },
        { title: 'given up', number: true, of: (one) => count(one.given_up ?? 0) },
        { title: 'what followed', of: (one) => <>{one.reason && <div>{one.reason}</div>}{one.results.map((result, i) => <div key={i}><Verdict kind={result.good ? 'good' : 'bad'}>{result.text}</Verdict></div>)}</> },
      ]}
    />
  );
}

function Story({ report }: { report: Report }) {
  const lines = useMemo(() => storyOf(report).map((one, i) => ({ ...one, i })), [report]);
  return (
    <Table
      caption="What happened, oldest first"
      rows={lines}
      keyOf={(one) => one.i}
      page={60}
      columns={[
        { title: 'when', of: (one) => <span class="nowrap">{at(one.time)}</span> },
        { title: 'what', of: (one) => <Verdict kind={one.kind}>{one.what}</Verdict> },
      ]}
    />
  );
}

const ofPriority: Record<string, VerdictKind> = { low: 'idle', medium: 'warn', high: 'bad', critical: 'bad' };

function Alarms({ alarms }: { alarms: readonly ReportAlarm[] }) {
  return (
    <Table
      caption="Alarms that stood meanwhile, oldest first"
      rows={alarms}
      keyOf={(one) => one.id}
      page={40}
      columns={[
        { title: 'since', of: (one) => <span class="nowrap">{at(one.since)}</span> },
        { title: 'over', of: (one) => <span class="nowrap">{at(one.over)}</span> },
        { title: 'priority', of: (one) => <Verdict kind={ofPriority[one.priority] ?? 'warn'}>{one.priority}</Verdict> },
        { title: 'alarm', of: (one) => `${one.kind} of ${one.subject}` },
        { title: 'what', of: (one) => <>{one.message}{one.consequences.map((consequence) => <div key={consequence} class="muted">{consequence}</div>)}</> },
        { title: 'acknowledged', of: (one) => (one.acknowledged ? `by ${one.acknowledged_by}, ${at(one.acknowledged)}` : 'by nobody') },
      ]}
    />
  );
}

function Fitted({ model }: { model: ReportModel }) {
  const outputs = model.residuals.map(({ output, values }) => ({ output, values }));
  const rows = { timeS: model.timeS, validation: model.validation, excluded: model.timeS.map(() => false), variables: [], outputs };
  return (
    <Panel title={`Model ${model.id}${model.name && `, ${model.name}`}`}>
      <p><code>{model.formula}</code></p>
      {model.trouble && <p role="alert">{model.trouble}</p>}
      {model.accuracy.map((one) => (
        <p key={one.unit}>
          accuracy (A90) <strong>{figure(one.figures.a90)} {unitSign(one.unit)}</strong> ({one.output}, {rowsInWords(one.rows)}, mean {meanFigure(one.figures.mean, one.figures.a90)} {unitSign(one.unit)}, S90 {figure(one.figures.u90)} {unitSign(one.unit)})
        </p>
      ))}
      {model.residuals.map((one) => {
        const [spec] = residualSpecs(rows, one.output, one.unit, model.accuracy.find((found) => found.output === one.output)?.figures.a90, `model-${model.id}`);
        return <Plot key={one.output} spec={{ ...spec, title: `Residuals of ${one.output}` }} height={220} />;
      })}
    </Panel>
  );
}

function Diagnosed({ of }: { of: ReportDiagnosis }) {
  return (
    <Panel title={`Diagnosis ${of.id}`}>
      <p>{of.verdict ? <>verdict <strong>{of.verdict}</strong> from <code>{of.baseline}</code></> : of.state}</p>
      {of.findings.length > 0 && <ol>{of.findings.map((sentence) => <li key={sentence}>{sentence}</li>)}</ol>}
      {of.left_over.map((rest) => <p key={rest}>not explained: {rest}</p>)}
      {of.extended && of.extended !== of.baseline && <p>with the findings <code>{of.extended}</code></p>}
    </Panel>
  );
}

// Where it stood first, what went with it after, what the stabilisers did last.
const order = [/^(x|y|z)_mm$/, /^r[xyz]_arcsec$/, /^q\d_mm$/, /^force_N$/, /^t\d/, /^air/];
const rank = (channel: string) => (order.findIndex((pattern) => pattern.test(channel.slice(robotOf(channel).length))) + order.length + 1) % (order.length + 1);

const digits: Record<string, number> = { mm: 6, degC: 3, arcsec: 2, nm: 1, N: 3, hPa: 2, pct: 1 };

function Verification({ of, run }: { of: ReportVerification; run: string }) {
  const figuresOf = (one: ReportVerification['coordinates'][number]['all']): Figures | undefined =>
    one === null ? undefined : { mean: one.mean, u90: one.u90, a90: one.a90, rowCount: one.row_count };
  return (
    <>
      {of.accuracy.map((one) => (
        <p key={one.unit} data-accuracy={one.figures.a90}>
          accuracy (A90) <strong>{figure(one.figures.a90)} {unitSign(one.unit)}</strong> ({one.output}, {rowsInWords(one.rows)}, mean {meanFigure(one.figures.mean, one.figures.a90)} {unitSign(one.unit)}, S90 {figure(one.figures.u90)} {unitSign(one.unit)})
        </p>
      ))}
      <VerificationTable run={run} of={{
        rows: of.row_count, outsideRows: of.outside_row_count, zeroRows: of.zero_row_count, outside: of.outside,
        coordinates: of.coordinates.map((one) => ({
          coordinate: one.coordinate, unit: one.unit, all: figuresOf(one.all), inside: figuresOf(one.inside), outside: figuresOf(one.outside),
          byModel: figuresOf(one.by_model), largest: one.largest, largestRow: one.largest_row,
        })),
      }} />
    </>
  );
}

function Points({ report }: { report: Report }) {
  const spread = spreads(report);
  const { points } = report;
  const channels = points.columns
    .filter((one) => !/_std_nm$/.test(one.channel) && one.values.some(Number.isFinite))
    .sort((a, b) => rank(a.channel) - rank(b.channel));
  const columns: Column<number>[] = [
    { title: 'row', number: true, sort: (i) => points.row[i], of: (i) => count(points.row[i]) },
    { title: 'line', number: true, of: (i) => count(points.line[i]) },
    { title: 'set', of: (i) => (points.zero[i] ? 'zero' : points.validation[i] ? 'validation' : 'calibration') },
    ...(spread ? [{ title: 'spread, nm', number: true, sort: (i: number) => spread[i], of: (i: number) => significant(spread[i], 2) }] : []),
    { title: 'tries', number: true, sort: (i) => points.tries[i], of: (i) => count(points.tries[i]) },
    ...channels.map((one): Column<number> => {
      const { symbol, unit } = splitChannel(one.channel);
      return { title: `${symbol.replaceAll('_', ' ')}${unitSign(unit) && `, ${unitSign(unit)}`}`, number: true, of: (i) => fixed(one.values[i], digits[unit] ?? 3) };
    }),
  ];
  return <Table caption="Points of the run, in order of time" rows={points.timeS.map((_, i) => i)} keyOf={(i) => i} columns={columns} page={40} />;
}

function Attempts({ report }: { report: Report }) {
  return (
    <Table
      caption="Attempts that were not accepted"
      rows={report.attempts}
      keyOf={(one) => `${one.row} ${one.number}`}
      columns={[
        { title: 'row', number: true, of: (one) => count(one.row) },
        { title: 'attempt', number: true, of: (one) => count(one.number) },
        { title: 'verdict', of: (one) => <Verdict kind={one.verdict === 'given_up' ? 'bad' : 'warn'}>{one.verdict.replaceAll('_', ' ')}</Verdict> },
        { title: 'why', of: (one) => one.reason },
        { title: 'spread, nm', number: true, of: (one) => (one.spread_nm === null ? '–' : significant(one.spread_nm, 2)) },
        { title: 'after', number: true, of: (one) => duration(one.time_s) },
      ]}
    />
  );
}

function Closures({ closures }: { closures: NonNullable<Report['closures']> }) {
  return (
    <Table
      caption="Returns to zero as they were judged"
      rows={closures.map((one, i) => ({ ...one, i }))}
      keyOf={(one) => one.i}
      page={40}
      columns={[
        { title: 'when', of: (one) => <span class="nowrap">{at(one.time)}</span> },
        { title: 'line', number: true, of: (one) => `${one.line}${one.repetition ? ', again' : ''}` },
        { title: 'verdict', of: (one) => <Verdict kind={['within', 'explained', 'play'].includes(one.decision) ? 'good' : 'warn'}>{one.decision.replaceAll('_', ' ')}</Verdict> },
        { title: 'why', of: (one) => one.sentence },
      ]}
    />
  );
}

function Events({ report }: { report: Report }) {
  return (
    <Table
      caption="The record of the run, oldest first"
      rows={report.events.map((one, i) => ({ ...one, i }))}
      keyOf={(one) => one.i}
      page={40}
      columns={[
        { title: 'when', of: (one) => <span class="nowrap">{at(one.time)}</span> },
        { title: 'who', of: (one) => one.who },
        { title: 'what', of: (one) => one.detail || one.what },
      ]}
    />
  );
}
