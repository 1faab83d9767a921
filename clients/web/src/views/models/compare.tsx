// Two models side by side, term by term.
import { modelApi } from '@/api/model';
import type { CompareModelsResponse_Row, CompareModelsResponse_Row_Cell } from '@/api/gen/driftwise/v1/model_service_pb';
import { query } from '@/app/router';
import { significant } from '@/format/numbers';
import { splitChannel } from '@/format/units';
import { AccuracyHeading, figure, meanFigure } from '@/ui/accuracy';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { ViewTitle } from '@/ui/view_title';
import { outputSymbol, sourceText, summaryUnit } from './figures';

const idOf = (text: string | undefined): bigint | undefined => (text && /^\d+$/.test(text) ? BigInt(text) : undefined);

export function ComparePage() {
  const a = idOf(query('a'));
  const b = idOf(query('b'));
  const key = a !== undefined && b !== undefined ? `compare ${a} ${b}` : undefined;
  const asked = useAsked(key, (signal) => modelApi().compareModels({ modelIds: [a!, b!] }, { signal }));
  const answer = asked.value;
  return (
    <>
      <ViewTitle sub={<a href="/models">All models</a>}>{key ? `Models ${a} and ${b}` : 'Compare models'}</ViewTitle>
      {!key && <Empty next={<a href="/models">Mark two models in the list</a>}>The address names no two models (?a=11&b=12).</Empty>}
      {asked.failure && <Failed asked="Compare" failure={asked.failure} again={asked.again} />}
      {answer && (
        <>
          <div class="columns">
            {answer.models.map((model) => (
              <Panel key={String(model.id)} title={<a href={`/models/${model.id}`}>Model {String(model.id)}{model.serving ? ', serves' : ''}</a>}>
                <p><code>{model.formula}</code></p>
                <p class="muted">from {sourceText(model)}</p>
                <AccuracyHeading of={model.accuracy} />
                <Table
                  caption={`Accuracy of model ${model.id}`}
                  rows={model.outputs}
                  keyOf={(output) => output.channel}
                  columns={[
                    { title: 'output', of: outputSymbol },
                    { title: 'A90 validation', number: true, of: (output) => `${figure(output.accuracy?.a90Validation)} ${summaryUnit(output)}` },
                    { title: 'mean', number: true, of: (output) => `${meanFigure(output.accuracy?.meanValidation, output.accuracy?.a90Validation)} ${summaryUnit(output)}` },
                    { title: 'A90 blocks', number: true, of: (output) => `${figure(output.accuracy?.a90Blocks)} ${summaryUnit(output)}` },
                    { title: 'A90 calibration', number: true, of: (output) => `${figure(output.accuracy?.a90Calibration)} ${summaryUnit(output)}` },
                    { title: 'terms', number: true, of: (output) => output.terms.filter((term) => term.included).length },
                  ]}
                />
              </Panel>
            ))}
          </div>
          <Panel title="Term by term">
            <p class="note muted">coefficient ± standard error, and its contribution; a dash: offered and left out; empty: not offered</p>
            <Table
              caption="Terms of both models"
              rows={answer.rows}
              keyOf={(row) => `${row.channel} ${row.term}`}
              rowClass={(row) => (row.cells.every((cell) => !cell.included) ? 'models-out' : undefined)}
              columns={[
                { title: 'output', of: (row: CompareModelsResponse_Row) => splitChannel(row.channel).symbol },
                { title: 'term', of: (row) => <code>{row.term}</code> },
                ...answer.models.map((model, i) => ({ title: `model ${model.id}`, number: true, of: (row: CompareModelsResponse_Row) => cellText(row.cells[i]) })),
              ]}
            />
          </Panel>
        </>
      )}
      {key && !answer && !asked.failure && <Awaiting what="the two models" />}
    </>
  );
}

function cellText(cell: CompareModelsResponse_Row_Cell | undefined): string {
  if (!cell?.offered) return '';
  if (!cell.included) return '–';
  const e = (value: number, digits: number) => value.toExponential(digits).replace('e+', 'e').replaceAll('-', '−');
  return `${e(cell.coefficient, 4)} ± ${e(cell.standardError, 1)}${cell.contributionRms !== undefined ? `; ${significant(cell.contributionRms, 2)} nm` : ''}`;
}
