// Remarks at an instant: written here, marks in the plots of a run over that time.
import { useMemo } from 'preact/hooks';
import { dateClock, fromUtc, ms, timestampOf } from '@/format/time';
import { CommandButton } from '@/ui/button';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { lookBackApi } from '@/api/look_back';

export function Notes() {
  const asked = useAsked('time notes', async (signal) => lookBackApi().listTimeNotes({}, { signal }));
  const [text, setText, taken] = useTyped('time-note');
  const [at, setAt, atTaken] = useTyped('time-note.at');
  const atMs = at.trim() === '' ? undefined : fromUtc(at.trim());
  const wrong = at.trim() !== '' && atMs === undefined ? 'UTC like 2026-11-22T18:00:00Z, or blank for now' : undefined;
  const requestId = useMemo(() => crypto.randomUUID?.() ?? '', [text, at]); // a second press is the same remark
  const pin = useCommand(async () => {
    await lookBackApi().addTimeNote({ text, requestId, ...(atMs !== undefined && { noteTime: timestampOf(atMs) }) });
    taken(), atTaken();
    asked.again();
  });
  const notes = asked.value?.notes;
  return (
    <Panel title="Remarks at a time">
      <div class="filters">
        <Field label="What happened" value={text} onInput={setText} />
        <Field label="When, UTC" value={at} onInput={setAt} wrong={wrong} hint="blank: now" />
        <CommandButton busy={pin.busy} off={wrong ?? (text.trim() === '' ? 'Write what happened' : undefined)} onPress={() => void pin.send()}>Pin it</CommandButton>
      </div>
      {pin.failure && <Failed asked="Pin the remark" failure={pin.failure} />}
      {asked.failure && <Failed asked="List the remarks" failure={asked.failure} again={asked.again} />}
      {!notes && !asked.failure && <Awaiting what="the remarks" />}
      {notes && notes.length === 0 && <Empty>No remark is pinned to a time.</Empty>}
      {notes && notes.length > 0 && (
        <Table
          caption="Remarks, newest first"
          rows={notes}
          keyOf={(note) => String(note.id)}
          columns={[
            { title: 'at', of: (note) => <span class="nowrap">{dateClock(ms(note.noteTime))}</span> },
            { title: 'remark', of: (note) => note.text },
            { title: 'channel', of: (note) => note.channel || '–' },
            { title: 'by', of: (note) => note.who },
          ]}
        />
      )}
    </Panel>
  );
}
