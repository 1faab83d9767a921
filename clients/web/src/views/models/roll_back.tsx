// The model that served before serves again: asked with what a promotion of it would be asked, and with whether the runs since agree
// with it, as `driftwise model rollback` does.
import { Code, ConnectError } from '@connectrpc/connect';
import { failureOf } from '@/api/errors';
import type { CheckModelResponse, Promotion } from '@/api/gen/driftwise/v1/model_service_pb';
import { CheckModelResponse_Verdict, Promotion_Action } from '@/api/gen/driftwise/v1/model_service_pb';
import { modelApi } from '@/api/model';
import { servedBefore } from '@/parts/served';
import { CommandButton } from '@/ui/button';
import { confirm, type Question } from '@/ui/confirm';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { served } from './actions';
import { headingText } from './figures';

const servedOf = (oldestFirst: readonly Promotion[]) => servedBefore(oldestFirst.map((one) => ({ id: one.modelId, rollback: one.action === Promotion_Action.ROLLBACK })));

// What the runs since it was made say against it; undefined: they agree with it.
export function doubtAbout(id: bigint, check: Pick<CheckModelResponse, 'verdict' | 'reasons'>): string | undefined {
  if (check.verdict === CheckModelResponse_Verdict.IN_CONTROL) return undefined;
  if (check.verdict !== CheckModelResponse_Verdict.RECALIBRATE) return `no run since model ${id} was made shows whether the robot still does what it says`;
  return `the robot no longer does what model ${id} says${check.reasons.length > 0 ? `: ${check.reasons.join('; ')}` : ''}`;
}

const uncheckedText = (id: bigint, error: unknown) => `model ${id} could not be checked against the runs since: ${failureOf(error).message}`;

async function questionOf(now: bigint, before: bigint | undefined): Promise<Question> {
  const affected = ['who is affected', 'every controller and run that asks for targets, from its next target on'] as const;
  const title = `Roll back from ${served(now)}?`;
  const keep = `Keep ${served(now)}`;
  if (before === undefined)
    return {
      title, keep, bad: true, verb: 'Serve no model', facts: [['serves now', served(now)], ['from then on', 'no model'], affected],
      words: 'No model served before it: every target is refused (NO_MODEL) until one is promoted.',
    };
  const [page, doubt] = await Promise.all([
    modelApi().getModel({ modelId: before }),
    modelApi().checkModel({ modelId: before }).then((check) => doubtAbout(before, check), (error) => uncheckedText(before, error)),
  ]);
  const against = [...page.promotionQuestions, ...(doubt === undefined ? [] : [doubt])];
  return {
    title, keep, bad: against.length > 0, verb: `Serve ${served(before)}${against.length > 0 ? ' all the same' : ''}`,
    facts: [
      ['serves now', served(now)],
      ['from then on', served(before)],
      ['formula', page.model?.formula],
      ['accuracy (A90)', page.model && headingText(page.model)],
      affected,
      ...against.map((words) => ['although', words] as const),
    ],
  };
}

// Asked and answered of the same history: a promotion or rollback of somebody else in between is no part of the answer.
async function rollBack() {
  const seen = await history();
  if (seen.now === undefined || !(await confirm(await questionOf(seen.now, seen.before)))) return;
  const present = await history();
  if (present.now !== seen.now || present.before !== seen.before)
    throw new ConnectError(`nothing was rolled back: ${served(present.now)} serves by now, where you were asked about ${served(seen.now)}; look at the list, then try again`, Code.FailedPrecondition);
  await modelApi().rollBackModel({});
}

const history = async () => servedOf((await modelApi().listPromotions({})).promotions);

// promotions: newest first, as the list shows them.
export function RollBack({ promotions, onDone }: { promotions: readonly Promotion[]; onDone: () => void }) {
  const command = useCommand(() => rollBack().finally(onDone));
  const off = servedOf([...promotions].reverse()).now === undefined ? 'No model serves: there is none to take back' : undefined;
  return (
    <>
      <CommandButton busy={command.busy} off={off} onPress={() => command.send()}>Roll back…</CommandButton>
      {command.failure && <Failed asked="Roll back" failure={command.failure} />}
    </>
  );
}
