// What a finding's parameters are, each with the interval it is known to.
import type { Finding, FindingParameter } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { significant } from '@/format/numbers';
import { parameterTables } from './parameters';
import { isWhole, parameterText, parameterWords } from './words';

export function Parameters({ finding }: { finding: Finding }) {
  const tables = parameterTables(finding);
  return (
    <>
      {(tables.single.length > 0 || tables.shared.length === 0) && <Single finding={finding} rows={tables.single} withAmplitudes={tables.shared.length === 0} />}
      {tables.shared.length > 0 && <Shared finding={finding} />}
      {finding.terms.length > 0 && <p class="note"><span class="muted">terms </span><code class="diagnosis-terms">{finding.terms.join('  ')}</code></p>}
    </>
  );
}

function Single({ finding, rows, withAmplitudes }: { finding: Finding; rows: readonly FindingParameter[]; withAmplitudes: boolean }) {
  const amplitudes = withAmplitudes ? parameterTables(finding).amplitudes : [];
  if (rows.length + amplitudes.length === 0) return null;
  return (
    <div class="table-scroll" tabIndex={0} role="region" aria-label={`Parameters of finding ${finding.number}`}>
      <table class="diagnosis-parameters">
        <thead><tr><th scope="col">parameter</th><th scope="col" class="number">value</th><th scope="col" class="number">90 % interval</th></tr></thead>
        <tbody>
          {rows.map((one) => {
            const { name, unit } = parameterWords(one.name);
            return (
              <tr key={one.name}>
                <td>{name}</td>
                <td class="number">{parameterText(one.value, one.ci90, isWhole(name))} {unit}</td>
                <td class="number">{one.ci90 ? `${parameterText(one.ci90.low, one.ci90)} to ${parameterText(one.ci90.high, one.ci90)} ${unit}` : '–'}</td>
              </tr>
            );
          })}
          {amplitudes.map((one) => (
            <tr key={one.output}><td>amplitude, {one.output}</td><td class="number">{significant(one.amplitude, 3)} {one.unit}</td><td class="number">–</td></tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Shared({ finding }: { finding: Finding }) {
  const { shared, outputs, amplitudes } = parameterTables(finding);
  return (
    <div class="table-scroll" tabIndex={0} role="region" aria-label={`Parameters of finding ${finding.number} by output`}>
      <table class="diagnosis-parameters">
        <thead><tr><th scope="col">value, 90 % interval</th><th scope="col">unit</th>{outputs.map((output) => <th key={output} scope="col" class="number">{output}</th>)}</tr></thead>
        <tbody>
          {shared.map((row) => (
            <tr key={row.name + row.unit}>
              <th scope="row">{row.name}</th>
              <td>{row.unit}</td>
              {outputs.map((output) => <td key={output} class="number"><Cell of={row.of.get(output)} /></td>)}
            </tr>
          ))}
          {amplitudes.length > 0 && (
            <tr>
              <th scope="row">amplitude</th>
              <td>{amplitudes[0].unit}</td>
              {outputs.map((output) => <td key={output} class="number">{significant(amplitudes.find((one) => one.output === output)?.amplitude, 3)}</td>)}
            </tr>
          )}
        </tbody>
      </table>
    </div>
  );
}

function Cell({ of }: { of: FindingParameter | undefined }) {
  if (!of) return <>–</>;
  return (
    <>
      {parameterText(of.value, of.ci90)}
      {of.ci90 && <span class="note muted diagnosis-interval">{parameterText(of.ci90.low, of.ci90)} to {parameterText(of.ci90.high, of.ci90)}</span>}
    </>
  );
}
