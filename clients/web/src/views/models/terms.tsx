// Every offered term with what it contributes. Contributions span decades, so their bars are logarithmic and say so.
import type { Model, ModelOutput, ModelTerm } from '@/api/gen/driftwise/v1/model_service_pb';
import { probability, significant } from '@/format/numbers';
import { Bar } from '@/ui/bar';
import { Panel } from '@/ui/panel';
import { Table } from '@/ui/table';
import { Verdict } from '@/ui/verdict';
import { OutputChoice, useOutput } from './output_choice';
import { outputSymbol, summaryUnit } from './figures';

export function TermsTab({ model }: { model: Model }) {
  const output = useOutput(model);
  return (
    <Panel title={`Terms of ${outputSymbol(output)}`} actions={<OutputChoice model={model} />}>
      <Terms output={output} />
    </Panel>
  );
}

// Standard error of a contribution: as large a part of it as that of the coefficient, allowing for rows that are not
// independent where the fit says so.
export function contributionError(term: ModelTerm): number | undefined {
  if (term.contributionRms === undefined || term.coefficient === 0) return undefined;
  return term.contributionRms * Math.abs((term.standardErrorSerial ?? term.standardError) / term.coefficient);
}

// Decades from the smallest to the largest contribution, as shares of the bar.
export function logScale(values: readonly number[]): (value: number) => number {
  const positive = values.filter((value) => value > 0);
  const low = Math.floor(Math.log10(Math.min(...positive, 1)));
  const high = Math.ceil(Math.log10(Math.max(...positive, 1)) + 1e-9);
  return (value) => (value > 0 ? Math.max(0, (Math.log10(value) - low) / Math.max(1, high - low)) : 0);
}

function Terms({ output }: { output: ModelOutput }) {
  const unit = summaryUnit(output);
  const scale = logScale(output.terms.map((term) => term.contributionRms ?? 0));
  const rows = [...output.terms].sort((a, b) => Number(b.included) - Number(a.included) || (b.contributionRms ?? 0) - (a.contributionRms ?? 0));
  return (
    <>
      <p class="note muted">Contribution: standard deviation over the calibration rows, {unit}, with its standard error; bars on a logarithmic scale. Terms left out: as if each alone were added.</p>
      <Table
        caption={`Table of the terms of ${outputSymbol(output)}`}
        rows={rows}
        keyOf={(term) => term.term}
        rowClass={(term) => (term.included ? undefined : 'models-out')}
        columns={[
          { title: 'term', sort: (term) => term.term, of: (term) => <code>{term.term}</code> },
          { title: 'state', of: (term) => (term.included ? <Verdict kind="good">in</Verdict> : <Verdict kind="idle">out</Verdict>) },
          { title: 'on a log scale', of: (term) => term.contributionRms !== undefined && <TermBar term={term} scale={scale} /> },
          { title: `contribution, ${unit}`, number: true, sort: (term) => term.contributionRms ?? -1, of: (term) => contributionText(term) },
          { title: 'coefficient', number: true, of: (term) => `${exponent(term.coefficient)} ${unitText(term.unit)}` },
          { title: 'standard error', number: true, of: (term) => exponent(term.standardErrorSerial ?? term.standardError) },
          { title: 't', number: true, sort: (term) => Math.abs(term.t), of: (term) => significant(term.t, 3) },
          { title: 'p', number: true, sort: (term) => term.p, of: (term) => probability(term.p) },
          { title: 'remark', of: (term) => term.note || (term.vif !== undefined && term.vif > 10 ? `variance inflated ${significant(term.vif, 2)} times` : '') },
        ]}
      />
    </>
  );
}

function contributionText(term: ModelTerm): string {
  if (term.contributionRms === undefined) return '';
  const error = contributionError(term);
  return `${significant(term.contributionRms, 3)}${error !== undefined ? ` ± ${significant(error, 2)}` : ''}`;
}

function exponent(value: number): string {
  if (value === 0 || !Number.isFinite(value)) return significant(value);
  if (Math.abs(value) >= 0.01 && Math.abs(value) < 1000) return significant(value, 4);
  return value.toExponential(3).replace('e+', 'e').replaceAll('-', '−');
}

// "mm/(mm^2 degC)" -> "mm/(mm² °C)"
const unitText = (unit: string): string => unit.replaceAll('degC', '°C').replaceAll('^2', '²').replaceAll('^3', '³').replaceAll(/\^(\d)/g, '^$1');

function TermBar({ term, scale }: { term: ModelTerm; scale: (value: number) => number }) {
  const value = term.contributionRms ?? 0;
  const error = contributionError(term) ?? 0;
  return <Bar share={scale(value)} low={scale(Math.max(value - error, 0))} high={scale(value + error)} />;
}
