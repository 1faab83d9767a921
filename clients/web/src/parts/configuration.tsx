// The cell file: under which one something was measured, and the question that a changed one puts.
import type { ConfigurationChange } from '@/api/gen/driftwise/v1/provenance_pb';
import type { GetModelResponse } from '@/api/gen/driftwise/v1/model_service_pb';
import { configurationApi } from '@/api/configuration';
import { dateClock, ms } from '@/format/time';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Panel } from '@/ui/panel';
import { Failed, Warned } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { cell } from '@/live/state';

// "probe t07_degC: input 107 → 108"
export function changeText(change: ConfigurationChange): string {
  if (change.key === '' && change.before === '') return `${change.place}: new: ${change.after}`;
  if (change.key === '' && change.after === '') return `${change.place}: gone: ${change.before}`;
  return `${change.place}: ${change.key && `${change.key} `}${change.before || 'not given'} → ${change.after || 'not given'}`;
}

export const ChangeList = ({ changes }: { changes: readonly ConfigurationChange[] }) => (
  <ul class="plain-list">{changes.map((change) => <li>{changeText(change)}{!change.asks && <span class="muted"> (recorded only)</span>}</li>)}</ul>
);

// The page to sign: the cell file of then, and what differs from the one of now.
export function MeasuredUnder({ answer }: { answer: GetModelResponse }) {
  if (answer.configHash === '') return <p class="note muted">Fitted from a file: no cell file is on record.</p>;
  const same = answer.configHash === answer.presentConfigHash;
  return (
    <details class="note">
      <summary>
        measured under cell file <code>{answer.configHash}</code>
        {answer.configurations.length > 1 && ` and ${answer.configurations.length - 1} before it`}
        {!same && (answer.changesSince.some((change) => change.asks) ? <Warned> the present one differs</Warned> : ', by meaning the present one')}
      </summary>
      {same ? <p>It is the present one.</p> : answer.changesSince.length === 0 ? <p>The present one, <code>{answer.presentConfigHash}</code>, is the same by meaning.</p> : <ChangeList changes={answer.changesSince} />}
    </details>
  );
}

// Stands while nobody has answered: runs wait, and models that use the changed parts are refused.
export function ConfigurationQuestion() {
  const open = cell.value?.attention.some((sentence) => sentence.startsWith('the cell file has changed')) ?? false;
  return open ? <Question /> : null;
}

function Question() {
  const asked = useAsked('configuration', async (signal) => (await configurationApi().listConfigurations({ limit: 1 }, { signal })).starts[0]);
  const accept = useCommand(async () => {
    await configurationApi().acceptConfiguration({ hash: asked.value!.hash });
    asked.again();
  });
  const start = asked.value;
  if (asked.failure) return <Failed asked="Show what changed in the cell file" failure={asked.failure} again={asked.again} />;
  if (!start || !start.asks || start.acceptTime) return null;
  const asking = start.changes.filter((change) => change.asks);
  const ask = async () => {
    const yes = await confirm({
      title: 'Accept the changed cell file?',
      facts: [
        ['since', <code>{start.beforeHash}</code>],
        ['changed', <ChangeList changes={asking} />],
        ['from then on', 'the unfinished run continues, and models that use these parts serve again'],
        ['else', 'put the file back and start the daemon again'],
      ],
      verb: 'Accept the change', keep: 'Leave it open',
    });
    if (yes) await accept.send();
  };
  return (
    <Panel title="The cell file has changed" actions={<CommandButton busy={accept.busy} onPress={ask}>Accept the change…</CommandButton>}>
      <p>Read at {dateClock(ms(start.startTime))}. An unfinished run waits, and targets of a model that uses what changed are refused, until somebody has looked at it.</p>
      <ChangeList changes={asking} />
      {accept.failure && <Failed asked="Accept the change" failure={accept.failure} />}
    </Panel>
  );
}
