import { trajectoryApi } from '@/api/trajectory';
import { go } from '@/app/router';
import { count } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { Button, CommandButton } from '@/ui/button';
import { Field } from '@/ui/field';
import { FileInput } from '@/ui/file_input';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { ViewTitle } from '@/ui/view_title';
import { TrajectoryCheck, useTrajectoryCheck } from './check';
import { GenerateForm } from './generate';

export function TrajectoryList() {
  const asked = useAsked('trajectories', async (signal) => (await trajectoryApi().listTrajectories({}, { signal })).trajectories);
  const [text, setText, textTaken] = useTyped('trajectory.text');
  const [name, setName, nameTaken] = useTyped('trajectory.name');
  const check = useTrajectoryCheck(text);
  const clear = () => {
    setText('');
    setName('');
  };
  const keep = useCommand(async () => {
    const { trajectory } = await trajectoryApi().createTrajectory({ name: name.trim() || 'trajectory', text });
    textTaken();
    nameTaken();
    go(`/trajectories/${trajectory!.id}`);
  });
  return (
    <>
      <ViewTitle sub="Points to visit, in order; a text once kept never changes">Trajectories</ViewTitle>
      <Panel title="Bring one">
        <div class="stack">
          <div class="row trajectories-bring">
            <FileInput
              label="a file, CSV"
              accept=".csv,text/csv,text/plain"
              chosen={text ? name || 'pasted' : undefined}
              mostBytes={8 << 20}
              onFile={({ name, bytes }) => {
                setText(new TextDecoder().decode(bytes));
                setName(name);
              }}
              onClear={clear}
            />
            <Field label="name" value={name} onInput={setName} />
          </div>
          <details open={text !== '' && text.length < 20_000 && check.failure !== undefined}>
            <summary>or paste it, or mend it</summary>
            <label class="field"><span>trajectory, CSV: q1_mm,… or x_mm,y_mm,z_mm; set, line, zero, force_N, dwell_s</span>
              <textarea class="mono" rows={10} spellcheck={false} value={text} onInput={(event) => setText(event.currentTarget.value)} />
            </label>
          </details>
          <GenerateForm onText={(made, called) => { setText(made); setName(called); }} />
          {text !== '' && (
            <div class="actions">
              <CommandButton kind="main" busy={keep.busy} off={check.failure ? 'It cannot be run as it is: see what the check says' : check.value ? undefined : 'The check is not done yet'} onPress={() => keep.send()}>Keep it</CommandButton>
              <Button onPress={clear}>Start afresh</Button>
            </div>
          )}
          {keep.failure && <Failed asked="Keep the trajectory" failure={keep.failure} />}
        </div>
      </Panel>
      {text.trim() !== '' && <TrajectoryCheck text={text} name={name} asked={check} />}
      <Panel title="Kept">
        {asked.failure && <Failed asked="List the trajectories" failure={asked.failure} again={asked.again} />}
        {!asked.value && !asked.failure && <Awaiting what="the trajectories" />}
        {asked.value?.length === 0 && <Empty next="Choose a file above, paste one, or generate a grid.">No trajectory yet.</Empty>}
        {asked.value && asked.value.length > 0 && (
          <Table
            caption="Trajectories, newest first"
            rows={asked.value}
            keyOf={(one) => String(one.id)}
            columns={[
              { title: 'number', number: true, sort: (one) => Number(one.id), of: (one) => String(one.id) },
              { title: 'name', sort: (one) => one.name, of: (one) => <a href={`/trajectories/${one.id}`}>{one.name}</a> },
              { title: 'rows', number: true, sort: (one) => Number(one.rowCount), of: (one) => count(one.rowCount) },
              { title: 'kept', of: (one) => dateClock(ms(one.createTime)) },
              { title: 'by', of: (one) => one.createdBy },
            ]}
          />
        )}
      </Panel>
    </>
  );
}
