// What is asked before another plan serves every joint target.
import { Code, ConnectError } from '@connectrpc/connect';
import type { CheckPlanResponse, Plan, PlanPromotion } from '@/api/gen/driftwise/v1/plan_service_pb';
import { servedBefore } from '@/parts/served';
import type { Question } from '@/ui/confirm';
import { plansApi } from './api';

const affected = ['who is affected', 'everybody who asks for joint targets, from the next target on'] as const;
export const planText = (id: bigint | undefined) => (id === undefined ? 'no plan' : `plan ${id}`);

export const questionsOf = (check: CheckPlanResponse) => check.findings.filter((finding) => !finding.refuses).map((finding) => finding.message);

export function promotionQuestion(id: bigint, now: bigint | undefined, questions: readonly string[]): Question {
  return {
    title: `Serve by plan ${id}?`,
    facts: [['serves now', planText(now)], ['from then on', planText(id)], affected, ...questions.map((words) => ['although', words] as const)],
    bad: questions.length > 0,
    verb: `Promote plan ${id}${questions.length > 0 ? ' all the same' : ''}`,
    keep: `Keep ${planText(now)}`,
  };
}

// The history is that of all plans, whichever is asked for.
export async function planHistory(plans: readonly Plan[]): Promise<ReturnType<typeof servedBefore>> {
  const any = plans[0];
  if (!any) return {};
  const { promotions } = await plansApi().getPlan({ planId: any.id });
  return servedBefore(promotions.map((one: PlanPromotion) => ({ id: one.planId, rollback: one.rollback })));
}

export async function rollBackQuestion(now: bigint, before: bigint | undefined): Promise<Question> {
  const common = { title: `Roll back from plan ${now}?`, keep: `Keep plan ${now}` };
  const facts = [['serves now', planText(now)], ['from then on', planText(before)], affected] as const;
  if (before === undefined)
    return { ...common, facts, bad: true, verb: 'Serve no plan', words: 'No plan served before it: joint targets are refused until one is promoted.' };
  const check = await plansApi().checkPlan({ planId: before });
  const against = check.findings.map((finding) => finding.message);
  return {
    ...common, bad: against.length > 0, verb: `Serve plan ${before}${against.length > 0 ? ' all the same' : ''}`,
    facts: [...facts, ...against.map((words) => ['although', words] as const)],
  };
}

export const changedMeanwhile = (now: bigint | undefined, seen: bigint) =>
  new ConnectError(`nothing was rolled back: ${planText(now)} serves by now, where you were asked about plan ${seen}; look at the list, then try again`, Code.FailedPrecondition);
