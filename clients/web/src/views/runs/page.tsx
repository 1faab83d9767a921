// One run: what it is at, and its tabs.
import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { api } from '@/api/client';
import type { GetRunResponse } from '@/api/gen/driftwise/v1/run_service_pb';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { usePrintFacts } from '@/app/print_head';
import { query, setQuery } from '@/app/router';
import { fixed } from '@/format/numbers';
import { dateClock, duration, ms, secondsOf } from '@/format/time';
import { useEvents } from '@/live/events';
import { useRunPoints } from '@/live/points';
import { Rests } from '@/parts/rests';
import { RunMarks } from '@/parts/run_marks';
import { RunButtons } from '@/parts/run_buttons';
import { compensationText, doneShare, isImported, isOver, stateWords, troubles } from '@/parts/run_words';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { Tabs, tabOf } from '@/ui/tabs';
import { useAsked } from '@/ui/use_asked';
import { Mark } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { DatasetTab } from './dataset_tab';
import { LogTab } from './log_tab';
import { PlotsTab } from './plots_tab';
import { PointsTab } from './points_tab';
import { VerificationTab } from './verification_tab';

const tabs = [
  { id: 'points', title: 'Points' },
  { id: 'plots', title: 'Plots' },
  { id: 'dataset', title: 'Dataset' },
  { id: 'verification', title: 'Verification' },
  { id: 'log', title: 'Log' },
];

function Head({ run }: { run: Run }) {
  const [kind, word] = stateWords[run.state];
  const from = ms(run.startTime);
  const to = ms(run.endTime);
  const imported = isImported(run);
  return (
    <Panel class="run-head">
      <div>
        <p class="run-word"><Mark kind={kind} size={22} /> {word}</p>
        {run.reason && <p>{run.reason}</p>}
      </div>
      <dl class="facts note">
        <dt>points</dt><dd>{String(run.acceptedCount)} of {String(run.rowCount)} ({fixed(doneShare(run) * 100)} %){!imported && `, ${troubles(run)}`}</dd>
        <dt>{imported ? 'imported' : to === undefined ? 'started' : 'measured'}</dt><dd>{dateClock(from)}{!imported && to !== undefined && from !== undefined && ` to ${dateClock(to)}, ${duration(secondsOf(run.elapsedDuration))}`}</dd>
        <dt>trajectory</dt><dd>{run.trajectoryName || '–'}</dd>
        {run.setup && <><dt>set-up</dt><dd>{run.setup}</dd></>}
        <dt>compensation</dt><dd>{compensationText(run)}</dd>
        <dt>{imported ? 'imported by' : 'started by'}</dt><dd>{run.operatorName || 'unknown'}</dd>
        {run.metadata.length > 0 && <><dt>metadata</dt><dd>{run.metadata.map((item) => `${item.key}=${item.value}`).join(', ')}</dd></>}
        {run.queueEntryId !== undefined && <><dt>queue</dt><dd><a href="/queue">entry {String(run.queueEntryId)}</a></dd></>}
        <dt>cell file</dt><dd>{run.configHash ? <code>{run.configHash}</code> : 'none: its rows are a file\'s, imported'}{run.configurations.slice(1).map((one) => <>, from {dateClock(ms(one.fromTime))} on <code>{one.hash}</code></>)}</dd>
      </dl>
      {!isOver(run) && <RunButtons run={run} />}
    </Panel>
  );
}

export function RunPage({ id }: { id: bigint }) {
  const asked = useAsked<GetRunResponse>(`run ${id}`, (signal) => api.run().getRun({ runId: id }, { signal }));
  const points = useRunPoints(id);
  // What it rests on comes with the first answer only.
  const newer = (run: Run | undefined) => run?.id === id && asked.set((old) => ({ ...old, run: old.run ? { ...run, configurations: old.run.configurations, corrections: old.run.corrections } : run }));
  useEvents('run', newer);
  useEvents('progress', (progress) => newer(progress.run));
  const row = query('point');
  const chosen = useSignal<number | undefined>(row === undefined ? undefined : Number(row));
  useEffect(() => {
    chosen.value = row === undefined ? undefined : Number(row);
  }, [row]);
  const pick = (key: number) => setQuery({ point: String(key) === row ? undefined : String(key) });

  const run = asked.value?.run;
  usePrintFacts([['cell file of the run', run?.configHash ?? '']]);
  const title = `Run ${id}${run?.name ? ` · ${run.name}` : ''}`;
  if (!run) {
    return (
      <>
        <ViewTitle sub={<a href="/runs">All runs</a>}>{title}</ViewTitle>
        {asked.failure ? <Failed asked={`Open run ${id}`} failure={asked.failure} again={asked.again} /> : <Awaiting what={`run ${id}`} />}
      </>
    );
  }
  const tab = tabOf(tabs);
  const part = { run, rulesJson: asked.value!.rulesJson, chosen, onPick: pick };
  return (
    <RunMarks run={run} points={points.value}>
      <ViewTitle sub={<a href="/runs">All runs</a>}>{title}</ViewTitle>
      <Head run={run} />
      <Rests marks={run.corrections} what="exports and fits see its data with" />
      <Tabs tabs={tabs} label={`Run ${id}`} />
      {points.failure && <Failed asked="List the points" failure={points.failure} again={points.again} />}
      {!points.value && !points.failure && <Awaiting what="the points" />}
      {points.value && tab === 'points' && <PointsTab {...part} points={points.value} />}
      {points.value && tab === 'plots' && <PlotsTab {...part} points={points.value} />}
      {points.value && tab === 'dataset' && <DatasetTab {...part} points={points.value} />}
      {tab === 'verification' && <VerificationTab run={run} />}
      {tab === 'log' && <LogTab run={run} />}
    </RunMarks>
  );
}
