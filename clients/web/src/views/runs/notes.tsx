// What people say about a run; kept for ever.
import { dataApi } from '@/api/data';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { CommandButton } from '@/ui/button';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';

export function Notes({ run }: { run: Run }) {
  const asked = useAsked(`notes ${run.id}`, async (signal) => (await dataApi().listNotes({ on: { runId: run.id } }, { signal })).notes);
  useEvents('record', (event) => void (event.runId === run.id && event.what === 'note.added' && asked.again()));
  const [text, setText, taken] = useTyped(`note.${run.id}`);
  const add = useCommand(async () => {
    const { note } = await dataApi().createNote({ on: { runId: run.id }, text: text.trim() });
    if (note) asked.set((old) => [...old.filter((one) => one.id !== note.id), note]);
    taken();
    setText('');
  });
  return (
    <Panel title="Notes">
      {asked.failure && <Failed asked="List the notes" failure={asked.failure} again={asked.again} />}
      {asked.value && asked.value.length > 0 && (
        <ul class="remarks">
          {asked.value.map((note) => (
            <li key={String(note.id)}>
              {note.on?.row !== undefined && <strong>row {String(note.on.row)}: </strong>}{note.text}{' '}
              <span class="muted note">{note.createdBy}, {dateClock(ms(note.createTime))}</span>
            </li>
          ))}
        </ul>
      )}
      <form class="stack" onSubmit={(event) => { event.preventDefault(); if (text.trim()) void add.send(); }}>
        <Field label="A note on this run" value={text} onInput={setText} />
        <div class="actions"><CommandButton submit busy={add.busy} off={text.trim() === '' ? 'Type a note first' : undefined}>Add the note</CommandButton></div>
        {add.failure && <Failed asked="Add the note" failure={add.failure} />}
      </form>
    </Panel>
  );
}
