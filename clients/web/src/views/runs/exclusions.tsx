// Rows kept out of every fit from now on, for a reason; nothing measured is altered, and it can be taken back.
import { dataApi } from '@/api/data';
import type { ExclusionState } from '@/api/gen/driftwise/v1/data_service_pb';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { count } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { rowsText, rowsTyped, type Rows } from './row_ranges';

function Form({ run, onState }: { run: Run; onState: (state: ExclusionState | undefined) => void }) {
  const [rows, setRows, rowsTaken] = useTyped(`exclude.rows.${run.id}`);
  const [reason, setReason, reasonTaken] = useTyped(`exclude.reason.${run.id}`);
  const read = rowsTyped(rows, Number(run.rowCount));
  const wrong = typeof read === 'string' ? read : undefined;
  const change = useCommand(async (out: boolean, ranges: Rows[]) => {
    const request = { runId: run.id, rows: ranges, reason: reason.trim() };
    onState((out ? await dataApi().excludeRows(request) : await dataApi().restoreRows(request)).state);
  });
  const ask = async (out: boolean) => {
    const ranges = read as Rows[];
    const yes = await confirm({
      title: out ? 'Keep these rows out of fits?' : 'Put these rows back into fits?',
      facts: [['Rows', rowsText(ranges)], ['Of', `run ${run.id}`], ['Reason', reason.trim()], ['Affects', 'every fit and diagnosis from now on; models that exist stay as they are']],
      verb: out ? 'Keep them out' : 'Put them back',
      keep: 'Leave them as they are',
    });
    if (!yes || !(await change.send(out, ranges))) return;
    rowsTaken(), reasonTaken();
  };
  const off = wrong ?? (reason.trim() === '' ? 'Say why first' : undefined);
  return (
    <div class="stack">
      <div class="filters">
        <Field label="Rows" value={rows} onInput={setRows} wrong={rows === '' ? undefined : wrong} hint="like 12-15, 40; numbers as in the table of points" />
        <Field label="Reason" value={reason} onInput={setReason} />
      </div>
      <div class="actions">
        <CommandButton off={off} busy={change.busy} onPress={() => void ask(true)}>Keep out of fits…</CommandButton>
        <CommandButton off={off} busy={change.busy} onPress={() => void ask(false)}>Put back…</CommandButton>
      </div>
      {change.failure && <Failed asked="Change the rows" failure={change.failure} />}
    </div>
  );
}

export function Exclusions({ run }: { run: Run }) {
  const asked = useAsked(`exclusions ${run.id}`, async (signal) => (await dataApi().listExclusions({ runId: run.id }, { signal })).state);
  useEvents('record', (event) => void (event.runId === run.id && event.what.startsWith('data.') && asked.again()));
  const state = asked.value;
  return (
    <Panel title={`Rows kept out of fits: ${state ? count(state.excludedRowCount) : '…'}`}>
      {asked.failure && <Failed asked="List what is kept out" failure={asked.failure} again={asked.again} />}
      {asked.waiting && !state && <Awaiting what="what is kept out" />}
      {state && state.excludedRows.length > 0 && <p>Out now: {rowsText(state.excludedRows)}</p>}
      {state && state.suspectRows.length > 0 && (
        <p>
          Suspect: {rowsText(state.suspectRows)}. The daemon marked them because an instrument or a zero was found false; put them back with a reason.
        </p>
      )}
      {state && state.history.length > 0 && (
        <ul class="remarks">
          {state.history.map((one) => (
            <li key={String(one.id)}>
              {one.suspect ? 'Marked as suspect' : one.excluded ? 'Kept out' : 'Put back'} {rowsText(one.rows)}: {one.reason}{' '}
              <span class="muted note">{one.excludedBy}, {dateClock(ms(one.excludeTime))}</span>
            </li>
          ))}
        </ul>
      )}
      <Form run={run} onState={(next) => next && asked.set(() => next)} />
    </Panel>
  );
}
