// The model that served before serves again: asked with what a promotion of it would be asked, and with whether the runs since agree
// with it, as `driftwise model rollback` does.
import { failureOf } from '@/api/errors';
import type { CheckModelResponse, Promotion } from '@/api/gen/driftwise/v1/model_service_pb';
import { CheckModelResponse_Verdict, Promotion_Action } from '@/api/gen/driftwise/v1/model_service_pb';
import { modelApi } from '@/api/model';
import { rollBack, servedBefore, type Serving } from '@/parts/served';
import { CommandButton } from '@/ui/button';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { affected } from './actions';
import { headingText } from './figures';

const served = (oldestFirst: readonly Promotion[]) => oldestFirst.map((one) => ({ id: one.modelId, rollback: one.action === Promotion_Action.ROLLBACK }));

// Doubt by the runs since it was made; undefined: they agree with it.
export function doubtAbout(id: bigint, check: Pick<CheckModelResponse, 'verdict' | 'reasons'>): string | undefined {
  if (check.verdict === CheckModelResponse_Verdict.IN_CONTROL) return undefined;
  if (check.verdict !== CheckModelResponse_Verdict.RECALIBRATE) return `no run since model ${id} was made shows whether the robot still does what it says`;
  return `the robot no longer does what model ${id} says${check.reasons.length > 0 ? `: ${check.reasons.join('; ')}` : ''}`;
}

const model: Serving = {
  what: 'model',
  affected,
  none: 'every target is refused (NO_MODEL)',
  history: async () => served((await modelApi().listPromotions({})).promotions),
  look: async (id) => {
    const [page, doubt] = await Promise.all([
      modelApi().getModel({ modelId: id }),
      modelApi().checkModel({ modelId: id }).then(
        (check) => doubtAbout(id, check),
        (error) => `model ${id} could not be checked against the runs since: ${failureOf(error).message}`,
      ),
    ]);
    return {
      facts: [['formula', page.model?.formula], ['accuracy (A90)', page.model && headingText(page.model)]],
      against: [...page.promotionQuestions, ...(doubt === undefined ? [] : [doubt])],
    };
  },
  rollBack: (servingModelId) => modelApi().rollBackModel({ servingModelId }),
};

// promotions: newest first, as the list shows them.
export function RollBack({ promotions, onDone }: { promotions: readonly Promotion[]; onDone: () => void }) {
  const command = useCommand(() => rollBack(model).finally(onDone));
  const off = servedBefore(served([...promotions].reverse())).now === undefined ? 'No model serves: there is none to take back' : undefined;
  return (
    <>
      <CommandButton busy={command.busy} off={off} onPress={() => command.send()}>Roll back…</CommandButton>
      {command.failure && <Failed asked="Roll back" failure={command.failure} />}
    </>
  );
}
