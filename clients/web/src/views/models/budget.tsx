// The uncertainty that targets would have, at the middle and at a corner of the fitted domain.
import type { GetModelResponse, PoseBudget } from '@/api/gen/driftwise/v1/model_service_pb';
import { significant } from '@/format/numbers';
import { splitChannel, unitSign } from '@/format/units';
import { BudgetTable } from '@/model/budget_table';
import { Panel } from '@/ui/panel';
import { Empty } from '@/ui/states';
import { Table } from '@/ui/table';

export function BudgetTab({ answer }: { answer: GetModelResponse }) {
  if (answer.budgets.length === 0)
    return <Panel><Empty>This model cannot serve targets, so it has no uncertainty of a target: it gives no motor coordinate, or it reads what a target cannot know.</Empty></Panel>;
  return (
    <>
      <div class="columns">{answer.budgets.map((budget) => <Place budget={budget} />)}</div>
      <Panel title="Declared in the cell file">
        {answer.declared.length === 0 ? <Empty>Nothing is declared.</Empty> : (
          <Table
            caption="Standard uncertainties that the cell file declares"
            rows={answer.declared}
            keyOf={(one) => `${one.deviceId} ${one.channel} ${one.name}`}
            columns={[
              { title: 'device', of: (one) => one.deviceId },
              { title: 'channel', of: (one) => one.channel },
              { title: 'key', of: (one) => <code>{one.name}</code> },
              { title: 'value', number: true, of: (one) => significant(one.value, 3) },
            ]}
          />
        )}
      </Panel>
    </>
  );
}

function Place({ budget }: { budget: PoseBudget }) {
  const pose = budget.pose.map(({ channel, value }) => {
    const { symbol, unit } = splitChannel(channel);
    return `${symbol} ${significant(value, 3)} ${unitSign(unit)}`;
  });
  return (
    <Panel title={`At the ${budget.place} of the domain`}>
      <p class="note muted">{pose.join(', ')}; temperatures in the middle of their ranges</p>
      <BudgetTable coordinates={budget.coordinates} />
    </Panel>
  );
}
