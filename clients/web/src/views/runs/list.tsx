// All runs, newest first, with search by number, name, trajectory, operator, metadata, and by state.
import { useEffect, useMemo, useState } from 'preact/hooks';
import { Run_State, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { go, query, setQuery } from '@/app/router';
import { count, fixed } from '@/format/numbers';
import { dateClock, duration, ms, secondsOf } from '@/format/time';
import { useRuns } from '@/parts/runs';
import { doneShare, isImported, isOver, stateWords } from '@/parts/run_words';
import { Button } from '@/ui/button';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { JoinPanel } from './join';

// A run begins when it is created, or is refused: campaigns that wait are the view Queue's.
const states = [Run_State.RUNNING, Run_State.PAUSED, Run_State.WAITING, Run_State.DONE, Run_State.ABORTED, Run_State.FAILED];

const metadataOf = (run: Run): string => run.metadata.map((item) => `${item.key}=${item.value}`).join(', ');

export function matches(run: Run, text: string, state: string): boolean {
  if (state !== '' && stateWords[run.state][1].toLowerCase() !== state) return false;
  const words = `${run.id} ${run.name} ${run.trajectoryName} ${run.operatorName} ${run.reason} ${run.setup} ${metadataOf(run)}`.toLowerCase();
  return text.toLowerCase().split(/\s+/).every((word) => words.includes(word));
}

const took = (run: Run): string => (!run.startTime || isImported(run) ? '–' : !run.endTime ? 'under way' : duration(secondsOf(run.elapsedDuration)));

interface Chosen {
  ids: readonly bigint[];
  set: (ids: readonly bigint[]) => void;
}

function RunTable({ runs, chosen }: { runs: readonly Run[]; chosen: Chosen | undefined }) {
  const toggle = ({ ids, set }: Chosen, id: bigint) => set(ids.includes(id) ? ids.filter((one) => one !== id) : [...ids, id]);
  return (
    <Table
      caption="Runs, newest first"
      rows={runs}
      keyOf={(run) => String(run.id)}
      columns={[
        ...(chosen ? [{ title: 'join', of: (run: Run) => <input type="checkbox" aria-label={`Join run ${run.id}`} checked={chosen.ids.includes(run.id)} onChange={() => toggle(chosen, run.id)} /> }] : []),
        { title: 'run', of: (run) => <a href={`/runs/${run.id}`}>{String(run.id)}</a>, sort: (run) => Number(run.id) },
        { title: 'name', of: (run) => run.name || '–', sort: (run) => run.name },
        ...(runs.some((run) => run.setup) ? [{ title: 'set-up', of: (run: Run) => run.setup || '–', sort: (run: Run) => run.setup }] : []),
        {
          title: 'state', sort: (run) => run.state,
          of: (run) => <Verdict kind={stateWords[run.state][0]}>{stateWords[run.state][1]}{!isOver(run) && `, ${fixed(doneShare(run) * 100)} %`}</Verdict>,
        },
        { title: 'points', number: true, of: (run) => `${count(run.acceptedCount)} of ${count(run.rowCount)}`, sort: (run) => Number(run.acceptedCount) },
        { title: 'given up', number: true, of: (run) => count(run.givenUpCount), sort: (run) => Number(run.givenUpCount) },
        { title: 'started', of: (run) => <span class="nowrap">{dateClock(ms(run.startTime))}</span>, sort: (run) => ms(run.startTime) ?? 0 },
        { title: 'took', of: (run) => <span class="nowrap">{took(run)}</span> },
        { title: 'compensated', of: (run) => (!run.compensated ? 'no' : run.compensatePlanId !== undefined ? <a href="/plans">plan {String(run.compensatePlanId)}</a> : run.compensateModelId !== undefined ? <a href={`/models/${run.compensateModelId}`}>model {String(run.compensateModelId)}</a> : 'yes'), sort: (run) => Number(run.compensateModelId ?? (run.compensated ? 0 : -1)) },
        { title: 'trajectory', of: (run) => run.trajectoryName || '–', sort: (run) => run.trajectoryName },
        { title: 'operator', of: (run) => run.operatorName || 'unknown', sort: (run) => run.operatorName },
        ...(runs.some((run) => run.metadata.length > 0) ? [{ title: 'metadata', of: metadataOf }] : []),
        ...(runs.some((run) => run.corrections.length > 0) ? [{ title: 'rests on', of: (run: Run) => run.corrections.map((mark) => `correction ${mark.correctionId}`).join(', ') }] : []),
      ]}
    />
  );
}

const enough = 20; // matches; older runs are looked through until there are so many

export function RunList() {
  const [joined, setJoined] = useState<readonly bigint[]>(); // undefined: nothing is being joined
  const asked = useRuns();
  const text = query('q') ?? '';
  const state = query('state') ?? '';
  const { value: all, isAll } = asked;
  const shown = useMemo(() => all?.filter((run) => matches(run, text, state)), [all, text, state]);
  const filters = text !== '' || state !== '';
  const looksOn = filters && !isAll && asked.failure === undefined && shown !== undefined && shown.length < enough;
  useEffect(() => {
    if (looksOn && !asked.asking) void asked.older();
  }, [looksOn, asked.asking, all]);
  return (
    <>
      <ViewTitle actions={<><Button onPress={() => setJoined([])}>Join runs…</Button> <Button kind="main" onPress={() => go('/trajectories')}>Start a run…</Button></>}>Runs</ViewTitle>
      {joined && <JoinPanel runs={joined} onClose={() => setJoined(undefined)} />}
      <Panel>
        <div class="filters">
          <Field label="Search" type="search" value={text} onInput={(q) => setQuery({ q })} />
          <label class="field">
            <span>State</span>
            <select class="input" value={state} onChange={(event) => setQuery({ state: event.currentTarget.value })}>
              <option value="">any</option>
              {states.map((one) => <option key={one} value={stateWords[one][1].toLowerCase()}>{stateWords[one][1]}</option>)}
            </select>
          </label>
        </div>
        {asked.failure && <Failed asked="List the runs" failure={asked.failure} again={asked.again} />}
        {!shown && !asked.failure && <Awaiting what="the runs" />}
        {all?.length === 0 && <Empty next={<a href="/trajectories">Upload or generate a trajectory</a>}>No run yet.</Empty>}
        {all && all.length > 0 && shown?.length === 0 && <Empty next={<a href="/runs">Show all</a>}>{isAll ? 'No run matches.' : `No run matches among the newest ${count(all.length)}; looking through older ones …`}</Empty>}
        {shown && shown.length > 0 && <RunTable runs={shown} chosen={joined && { ids: joined, set: setJoined }} />}
        {all && !isAll && <p class="more"><span class="muted note">{count(all.length)} newest runs{filters && ' searched'}</span> <Button small busy={asked.asking} onPress={() => void asked.older()}>Load older runs</Button></p>}
      </Panel>
    </>
  );
}
