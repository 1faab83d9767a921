import type { Model } from '@/api/gen/driftwise/v1/model_service_pb';
import { probability, significant } from '@/format/numbers';
import { Bar } from '@/ui/bar';
import { Panel } from '@/ui/panel';
import { Empty } from '@/ui/states';
import { Table } from '@/ui/table';
import { OutputChoice, useOutput } from './output_choice';
import { outputSymbol, summaryUnit } from './figures';
import { logScale } from './terms';

const words: Record<string, string> = { start: 'start', enter: '+', remove: '−' };

export function StepsTab({ model }: { model: Model }) {
  const output = useOutput(model);
  const scale = logScale(output.history.map((step) => step.rmse));
  return (
    <Panel title={`Steps of the selection, ${outputSymbol(output)}`} actions={<OutputChoice model={model} />}>
      {output.history.length === 0 ? (
        <Empty>All terms were taken at once: there were no steps.</Empty>
      ) : (
        <Table
          caption={`Steps of the selection of ${outputSymbol(output)}`}
          rows={output.history}
          keyOf={(step) => step.step}
          columns={[
            { title: 'step', number: true, of: (step) => step.step },
            { title: 'term', of: (step) => <code>{words[step.action] ?? step.action} {step.action === 'start' ? '' : step.term}</code> },
            { title: 'p', number: true, of: (step) => (step.action === 'start' ? '' : probability(step.p)) },
            { title: `RMSE, ${summaryUnit(output)}`, number: true, of: (step) => significant(step.rmse, 3) },
            { title: 'logarithmic', of: (step) => <Bar share={scale(step.rmse)} colour={step.action === 'remove' ? 'idle' : 'q1'} /> },
            { title: 'degrees of freedom', number: true, of: (step) => step.dof },
          ]}
        />
      )}
    </Panel>
  );
}
