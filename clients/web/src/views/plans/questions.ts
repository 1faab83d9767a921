// Questions before another plan serves every joint target.
import type { Plan } from '@/api/gen/driftwise/v1/plan_service_pb';
import { servedText, type Serving } from '@/parts/served';
import type { Question } from '@/ui/confirm';
import { plansApi } from './api';

const affected = 'everybody who asks for joint targets, from the next target on';

export function promotionQuestion(id: bigint, now: bigint | undefined, questions: readonly string[]): Question {
  return {
    title: `Serve by plan ${id}?`,
    facts: [['serves now', servedText('plan', now)], ['from then on', `plan ${id}`], ['who is affected', affected], ...questions.map((words) => ['although', words] as const)],
    bad: questions.length > 0,
    verb: `Promote plan ${id}${questions.length > 0 ? ' all the same' : ''}`,
    keep: `Keep ${servedText('plan', now)}`,
  };
}

export const servingPlan = (plans: readonly Plan[]): Serving => ({
  what: 'plan',
  affected,
  none: 'joint targets are refused',
  // The history is that of all plans, whichever is asked for.
  history: async () => (plans[0] ? (await plansApi().getPlan({ planId: plans[0].id })).promotions.map(({ planId, rollback }) => ({ id: planId, rollback })) : []),
  look: async (id) => ({ facts: [], against: (await plansApi().checkPlan({ planId: id })).findings.map((finding) => finding.message) }),
  rollBack: (servingPlanId) => plansApi().rollBackPlan({ servingPlanId }),
});
