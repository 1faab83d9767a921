// A joint target: asked for by a pose as typed, and shown for that text only, hatched when its conditions are over.
import { computed } from '@preact/signals';
import { useMemo, useState } from 'preact/hooks';
import type { JointTarget as Target } from '@/api/gen/driftwise/v1/plan_service_pb';
import { fixed, signed } from '@/format/numbers';
import { clock, ms } from '@/format/time';
import { connection } from '@/live/connection';
import { cellTimeMs } from '@/live/state';
import { flagsInWords } from '@/parts/flag_words';
import { Button } from '@/ui/button';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { Verdict } from '@/ui/verdict';
import { plansApi } from './api';
import { answeredBy, jointPoseTyped } from './words';

export function JointTarget() {
  const [text, setText] = useTyped('joint pose');
  const [answer, setAnswer] = useState<{ text: string; target: Target | undefined }>();
  const pose = jointPoseTyped(text);
  const ask = useCommand(async () => {
    const { target } = await plansApi().computeJointTarget({ pose: pose!, showUnreachable: true });
    setAnswer({ text, target });
  }, 'reads');
  const target = answer?.text === text ? answer.target : undefined;
  return (
    <Panel title="Joint target">
      <Field label="Wanted pose" hint="mm, arcsec, N: mn.x=1 mn.y=0.5 ma.rx=100" value={text} onInput={setText} mono />
      <Button busy={ask.busy} off={pose ? undefined : 'Coordinates with numbers, parted by blanks'} onPress={() => void ask.send()}>Ask</Button>
      {ask.failure && <Failed asked="Ask for a joint target" failure={ask.failure} />}
      {target && <Shown target={target} />}
    </Panel>
  );
}

function Shown({ target }: { target: Target }) {
  const isOver = useMemo(() => computed(() => connection.value.phase !== 'live' || !((cellTimeMs.value ?? Infinity) <= (ms(target.validUntilTime) ?? 0))), [target]);
  return (
    <div class={`stack${isOver.value ? ' stale' : ''}`}>
      <Table
        caption="Motor coordinates"
        rows={target.coordinates}
        keyOf={(one) => one.channel}
        columns={[
          { title: 'coordinate', of: (one) => <>{one.channel}{one.minMm !== undefined && <Verdict kind="bad">not reachable</Verdict>}</> },
          { title: 'mm', number: true, of: (one) => fixed(one.positionMm, 7) },
          { title: 'u, nm', number: true, of: (one) => fixed(one.uNm, 1) },
          { title: 'U90, nm', number: true, of: (one) => fixed(one.u90Nm, 1) },
        ]}
      />
      {target.terms.length > 0 && (
        <Table
          caption="Predicted motion, in the order in which it was added"
          rows={target.terms}
          keyOf={(one) => `${one.modelId} ${one.fromChannel}`}
          columns={[
            { title: 'predicted', of: (one) => one.fromChannel },
            { title: 'added to', of: (one) => one.toChannel || 'not corrected' },
            { title: 'value', number: true, of: (one) => `${signed(one.value, one.unit === 'nm' ? 1 : 3)} ${one.unit}` },
            { title: 'u', number: true, of: (one) => `${fixed(one.u, one.unit === 'nm' ? 1 : 3)} ${one.unit}` },
          ]}
        />
      )}
      {target.robots.map((robot) => <p key={robot.robot}>{robot.robot || 'The robot'}: {answeredBy(robot)}</p>)}
      {flagsInWords(target.flags).map((words) => <Verdict key={words} kind="warn">{words}</Verdict>)}
      <p class="note muted">conditions of {clock(ms(target.conditionsTime))}, good until {clock(ms(target.validUntilTime))}</p>
    </div>
  );
}
