// Plans: what a target of several robots, or of two models, is made of; which plan serves; a joint target.
import { useState } from 'preact/hooks';
import type { CheckPlanResponse, ListPlansResponse, Plan } from '@/api/gen/driftwise/v1/plan_service_pb';
import { fixed } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { rollBack } from '@/parts/served';
import { CommandButton, Button } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed, Warned } from '@/ui/states';
import { Table, type Column } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { plansApi } from './api';
import { JointTarget } from './joint_target';
import { promotionQuestion, servingPlan } from './questions';

export default function PlansView() {
  const asked = useAsked('plans', async (signal) => plansApi().listPlans({}, { signal }));
  useEvents('record', (event) => event.what.startsWith('plan.') && asked.again());
  return (
    <>
      <ViewTitle sub="What a target of several robots, or of two models, is made of">Plans</ViewTitle>
      {asked.failure && <Failed asked="List the plans" failure={asked.failure} again={asked.again} />}
      {!asked.value && !asked.failure && <Awaiting what="the plans" />}
      {asked.value && <Shown list={asked.value} again={asked.again} />}
    </>
  );
}

function Shown({ list, again }: { list: ListPlansResponse; again: () => void }) {
  const [chosen, setChosen] = useState<bigint | undefined>(list.plans.find((plan) => plan.serves)?.id ?? list.plans.at(-1)?.id);
  const columns: Column<Plan>[] = [
    { title: 'plan', of: (plan) => <Button small onPress={() => setChosen(plan.id)} label={`Show plan ${plan.id}`}>{String(plan.id)}</Button> },
    { title: 'name', of: (plan) => <>{plan.name}<span class="muted">, version {plan.version}</span></> },
    { title: 'models', of: (plan) => plan.modelIds.map((id, i) => <>{i > 0 && ', '}<a href={`/models/${id}`}>{String(id)}</a></>) },
    { title: 'added', of: (plan) => <span class="nowrap">{dateClock(ms(plan.createTime))} by {plan.createdBy}</span> },
    { title: 'state', of: (plan) => (plan.serves ? <Verdict kind="good">serves</Verdict> : <span class="muted">kept</span>) },
  ];
  const takeBack = useCommand(async () => {
    await rollBack(servingPlan(list.plans)).finally(again);
  });
  const serving = list.plans.find((plan) => plan.serves)?.id;
  const serves = serving !== undefined;
  return (
    <div class="stack">
      <Panel title="Plans" actions={serves && <CommandButton small busy={takeBack.busy} onPress={() => void takeBack.send()}>Roll back…</CommandButton>}>
        {list.trouble && <Warned>{list.trouble}</Warned>}
        {takeBack.failure && <Failed asked="Roll back" failure={takeBack.failure} />}
        {list.plans.length === 0
          ? <Empty next="driftwise plan add plan.toml">No plan is kept.</Empty>
          : <Table caption="Serving plans, oldest first" rows={list.plans} keyOf={(plan) => String(plan.id)} columns={columns} />}
      </Panel>
      {chosen !== undefined && <OnePlan key={String(chosen)} id={chosen} serving={serving} again={again} />}
      {serves && <JointTarget key={String(serving)} />}
    </div>
  );
}

function OnePlan({ id, serving, again }: { id: bigint; serving: bigint | undefined; again: () => void }) {
  const asked = useAsked(`plan ${id}`, async (signal) => plansApi().getPlan({ planId: id }, { signal }));
  const [check, setCheck] = useState<CheckPlanResponse>();
  const look = useCommand(async () => setCheck(await plansApi().checkPlan({ planId: id })), 'reads');
  const promote = useCommand(async () => {
    const found = await plansApi().checkPlan({ planId: id });
    setCheck(found);
    const questions = found.findings.filter((finding) => !finding.refuses).map((finding) => finding.message);
    if (found.findings.some((finding) => finding.refuses)) return;
    if (!(await confirm(promotionQuestion(id, serving, questions)))) return;
    await plansApi().promotePlan({ planId: id, confirmed: questions.length > 0, servingPlanId: serving ?? 0n }).finally(again);
  });
  return (
    <Panel
      title={`Plan ${id}`}
      actions={
        <>
          <Button small busy={look.busy} onPress={() => void look.send()}>Check</Button>
          <CommandButton small busy={promote.busy} onPress={() => void promote.send()}>Promote…</CommandButton>
        </>
      }
    >
      {asked.failure && <Failed asked="Show the plan" failure={asked.failure} again={asked.again} />}
      {look.failure && <Failed asked="Check the plan" failure={look.failure} />}
      {promote.failure && <Failed asked="Promote the plan" failure={promote.failure} />}
      {check && <Findings check={check} />}
      {asked.value && (
        <>
          <ol>{asked.value.steps.map((step) => <li key={step}>{step}</li>)}</ol>
          <details>
            <summary>plan.toml</summary>
            <pre>{asked.value.text}</pre>
          </details>
        </>
      )}
    </Panel>
  );
}

function Findings({ check }: { check: CheckPlanResponse }) {
  return (
    <div class="stack">
      {check.bands.map((band) => (
        <p key={band.robot}>
          The models of the blend{band.robot && ` of ${band.robot}`} differ by {fixed(band.largestDifferenceNm, 0)} nm of {band.largestChannel}
          {band.differenceArcsec > 0 && ` (${fixed(band.differenceArcsec, 1)} arcsec)`}; rates deviate by {fixed(band.rateShare, 3)} of the largest, below 0.5 is accepted.
        </p>
      ))}
      {check.findings.map((finding) => <Verdict key={finding.message} kind={finding.refuses ? 'bad' : 'warn'}>{finding.message}</Verdict>)}
      {!check.findings.some((finding) => finding.refuses) && <Verdict kind="good">can be promoted</Verdict>}
    </div>
  );
}
