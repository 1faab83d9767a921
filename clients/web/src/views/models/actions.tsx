// What changes which model serves: asked once, with from and to; the stream confirms it.
import { Code, ConnectError } from '@connectrpc/connect';
import { computed, signal } from '@preact/signals';
import type { Model } from '@/api/gen/driftwise/v1/model_service_pb';
import { ExportModelRequest_Format } from '@/api/gen/driftwise/v1/model_service_pb';
import { modelApi } from '@/api/model';
import { cell } from '@/live/state';
import { servedText } from '@/parts/served';
import { Button, CommandButton } from '@/ui/button';
import { confirm, ReasonField, reasonTaken } from '@/ui/confirm';
import { download } from '@/ui/download';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { headingText } from './figures';

export const affected = 'every controller and run that asks for targets, from its next target on';
const served = (id: bigint | undefined) => servedText('model', id);

// Questions of the moment when it is pressed, not of the page's load: a confirmation covers every question that the daemon has, so one
// that came after the dialog was opened promotes nothing; nor does one while another model serves than the dialog names. Those for a
// reason are answered in writing, as `driftwise model promote --reason` does.
export function Promote({ model, onDone }: { model: Model; onDone: () => void }) {
  const command = useCommand(async () => {
    const { promotionQuestions: questions, questionsForAReason: forReason } = await modelApi().getModel({ modelId: model.id });
    const now = cell.value?.servingModelId;
    const reason = signal('');
    const off = computed(() => (forReason.length > 0 && reason.value.trim() === '' ? `${forReason[0]}: write why it serves all the same` : undefined));
    const yes = await confirm({
      title: `Promote model ${model.id}?`,
      facts: [
        ['served now', served(now)],
        ['from then on', `model ${model.id}`],
        ['accuracy (A90)', headingText(model)],
        ['who is affected', affected],
        ['to undo', 'Roll back'],
        ...questions.map((question) => ['although', question] as const),
        ...(forReason.length > 0 ? [['for the record', <ReasonField id={`model ${model.id}`} label="Why it serves all the same" reason={reason} />] as const] : []),
      ],
      off,
      bad: questions.length > 0,
      verb: `Promote model ${model.id}${questions.length > 0 ? ' all the same' : ''}`,
      keep: `Keep ${served(now)}`,
    });
    if (!yes) return;
    const unread = (await modelApi().getModel({ modelId: model.id })).promotionQuestions.filter((question) => !questions.includes(question));
    if (unread.length > 0)
      throw new ConnectError(`model ${model.id} was not promoted: ${unread.join('; ')}. That was not so when you were asked; promote it again`, Code.FailedPrecondition);
    await modelApi().promoteModel({ modelId: model.id, confirmed: questions.length > 0, reason: reason.value.trim(), servingModelId: now ?? 0n });
    reasonTaken(`model ${model.id}`);
    onDone();
  });
  return (
    <>
      <CommandButton kind="main" busy={command.busy} off={model.serving ? 'It serves already' : undefined} onPress={() => void command.send()}>Promote…</CommandButton>
      {command.failure && <Failed asked={`Promote model ${model.id}`} failure={command.failure} />}
    </>
  );
}

// A geometry is no sum of terms: there is no C of it.
export function ExportButtons({ id, geometry }: { id: bigint; geometry: boolean }) {
  const command = useCommand(async (format: ExportModelRequest_Format) => {
    const { text, fileName } = await modelApi().exportModel({ modelId: id, format });
    download(fileName, text, 'text/plain');
  });
  return (
    <>
      <Button busy={command.busy} onPress={() => command.send(ExportModelRequest_Format.JSON)}>Export JSON</Button>
      {!geometry && <Button busy={command.busy} onPress={() => command.send(ExportModelRequest_Format.C)}>Export C</Button>}
      {command.failure && <Failed asked="Export the model" failure={command.failure} />}
    </>
  );
}
