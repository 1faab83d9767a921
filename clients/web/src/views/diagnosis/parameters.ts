// The parameters of a finding as tables: those that stand for one output each as a row with a column per output, the others a row
// each.
import type { Finding, FindingOutput, FindingParameter } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { parameterWords } from './words';

export interface SharedRow {
  name: string;
  unit: string;
  of: Map<string, FindingParameter>; // by output
}

export interface ParameterTables {
  single: readonly FindingParameter[];
  shared: readonly SharedRow[];
  outputs: readonly string[]; // columns of the shared ones
  amplitudes: readonly FindingOutput[];
}

export function parameterTables(finding: Finding): ParameterTables {
  const amplitudes = finding.outputs.filter((one) => one.shown || finding.outputs.length === 1);
  const rows = new Map<string, SharedRow>();
  const single: FindingParameter[] = [];
  for (const parameter of finding.parameters) {
    const output = finding.outputs.find((one) => parameter.name.endsWith(`_${one.output}`))?.output;
    if (output === undefined) {
      single.push(parameter);
      continue;
    }
    const { name: full, unit } = parameterWords(parameter.name);
    const name = full.replace(new RegExp(`, ${output}$`), '');
    const row = rows.get(`${name} ${unit}`) ?? { name, unit, of: new Map<string, FindingParameter>() };
    row.of.set(output, parameter);
    rows.set(`${name} ${unit}`, row);
  }
  const shared = [...rows.values()];
  const outputs = finding.outputs.map((one) => one.output).filter((output) => shared.some((row) => row.of.has(output)));
  return { single, shared, outputs, amplitudes };
}
