// Adds a campaign from the trajectories that the daemon keeps.
import { useState } from 'preact/hooks';
import { trajectoryApi } from '@/api/trajectory';
import { countRows } from '@/format/numbers';
import { fromUtc, timestampOf } from '@/format/time';
import { SetupChoice, useSetups } from '@/parts/setup_choice';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Field, numberTyped } from '@/ui/field';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { queueApi } from './api';
import { metadataTyped, startWords, type Terms } from './words';

export function AddEntry({ onAdded, startsAtOnce }: { onAdded: () => void; startsAtOnce: (terms: Terms) => boolean }) {
  const kept = useAsked('kept trajectories', async (signal) => (await trajectoryApi().listTrajectories({}, { signal })).trajectories);
  const [which, setWhich] = useState('');
  const [name, setName, nameTaken] = useTyped('queue.name');
  const [priority, setPriority, priorityTaken] = useTyped('queue.priority', '0');
  const [notBefore, setNotBefore, notBeforeTaken] = useTyped('queue.notBefore');
  const [after, setAfter, afterTaken] = useTyped('queue.after');
  const [condition, setCondition, conditionTaken] = useTyped('queue.condition');
  const [every, setEvery, everyTaken] = useTyped('queue.every');
  const [then, setThen, thenTaken] = useTyped('queue.then');
  const [meta, setMeta, metaTaken] = useTyped('queue.meta');
  const setups = useSetups();
  const [setup, setSetup] = useState('');
  const [setsAside, setSetsAside] = useState(false);
  const [requestId, setRequestId] = useState(() => crypto.randomUUID()); // a second press is the same entry
  const number = numberTyped(priority);
  const notBeforeMs = fromUtc(notBefore.trim());
  const wrong = {
    priority: number === undefined || !Number.isInteger(number) || Math.abs(number) > 1000 ? 'a whole number from -1000 to 1000' : undefined,
    notBefore: notBefore.trim() !== '' && notBeforeMs === undefined ? 'UTC as 2026-11-22T23:00:00Z' : undefined,
    after: after !== '' && !/^[1-9]\d*$/.test(after) ? 'the number of an entry' : undefined,
    every: every !== '' && !((numberTyped(every) ?? 0) > 0) ? 'a number above 0' : undefined,
    meta: metadataTyped(meta) ? undefined : 'key=value, parted by commas',
  };
  const off = which === '' ? 'Choose a trajectory first' : Object.values(wrong).find(Boolean);
  const add = useCommand(async () => {
    const { trajectory } = await trajectoryApi().getTrajectory({ trajectoryId: BigInt(which) });
    const yes = !startsAtOnce({ notBeforeMs, afterEntryId: after ? BigInt(after) : undefined }) || (await confirm({
      title: `Add "${name.trim() || trajectory!.name}" to the queue?`, verb: 'Add it', keep: 'Do not add it',
      facts: [['trajectory', `${trajectory!.name}, ${countRows(trajectory!.rowCount)}`], ['starts', startWords(condition.trim())]],
    }));
    if (!yes) return;
    await queueApi().addQueueEntry({
      name: name.trim(), trajectoryName: trajectory!.name, trajectoryText: trajectory!.text, priority: number!, condition: condition.trim(), setAsideOnFailure: setsAside,
      followUps: then.split('\n').map((line) => line.trim()).filter(Boolean), metadata: metadataTyped(meta)!, requestId, setup,
      ...(notBeforeMs === undefined ? {} : { notBeforeTime: timestampOf(notBeforeMs) }),
      ...(after ? { afterEntryId: BigInt(after) } : {}),
      ...(every ? { repeatDuration: { seconds: BigInt(Math.round(numberTyped(every)! * 3600)), nanos: 0 } } : {}),
    });
    setRequestId(crypto.randomUUID());
    for (const taken of [nameTaken, notBeforeTaken, afterTaken, conditionTaken, everyTaken, thenTaken, metaTaken, priorityTaken]) taken();
    setWhich(''), setSetup(''), setSetsAside(false);
    onAdded();
  });
  return (
    <details>
      <summary>Add a campaign</summary>
      {kept.failure && <Failed asked="List the kept trajectories" failure={kept.failure} again={kept.again} />}
      {!kept.value && !kept.failure && <Awaiting what="the kept trajectories" />}
      {kept.value && (
        <div class="stack">
          <div class="queue-form">
            <label class="field">
              <span>Trajectory</span>
              <select class="input" value={which} onChange={(event) => setWhich(event.currentTarget.value)}>
                <option value="">choose a kept one</option>
                {kept.value.map((one) => <option key={String(one.id)} value={String(one.id)}>{one.name}, {countRows(one.rowCount)}</option>)}
              </select>
            </label>
            <Field label="Name" value={name} onInput={setName} hint="empty: the trajectory's" />
            <Field label="Priority" type="number" value={priority} onInput={setPriority} wrong={wrong.priority} hint="higher first" />
            <Field label="Not before (UTC)" value={notBefore} onInput={setNotBefore} wrong={wrong.notBefore} hint="2026-11-22T23:00:00Z" />
            <Field label="After entry" value={after} onInput={setAfter} wrong={wrong.after} hint="only when that one was accepted" />
            <Field label="When" value={condition} onInput={setCondition} mono hint="t12 < 20.5 degC for 30 min" />
            <Field label="Repeat every" unit="h" type="number" value={every} onInput={setEvery} wrong={wrong.every} hint="empty: once" />
            <SetupChoice names={setups.value} value={setup} onChoose={setSetup} />
            <Field label="Metadata" value={meta} onInput={setMeta} wrong={wrong.meta} hint="sample=A12, tool=probe" />
          </div>
          <label class="field">
            <span>Then, an action a line</span>
            <textarea class="input mono" rows={3} value={then} placeholder={'fit:q ~ x + x^2\ndiagnose\nreport\nnotify'} onInput={(event) => setThen(event.currentTarget.value)} />
          </label>
          <label><input type="checkbox" checked={setsAside} onChange={(event) => setSetsAside(event.currentTarget.checked)} /> set aside on failure, and start the next one</label>
          <div class="actions"><CommandButton kind="main" busy={add.busy} off={off} onPress={() => void add.send()}>Add to the queue…</CommandButton></div>
          {add.failure && <Failed asked="Add the campaign" failure={add.failure} />}
        </div>
      )}
    </details>
  );
}
