// What the model leaves unexplained, row by row: over time and against everything it may go with, calibration and
// validation apart, all on one scale.
import { useMemo, useState } from 'preact/hooks';
import { modelApi } from '@/api/model';
import type { ListResidualsResponse, Model, ModelOutput } from '@/api/gen/driftwise/v1/model_service_pb';
import { countRows, significant } from '@/format/numbers';
import { Plot } from '@/plot/plot';
import { FileInput } from '@/ui/file_input';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed, Warned } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { outputSymbol, summaryUnit } from './figures';
import { OutputChoice, useOutput } from './output_choice';
import { RowsMarks } from '@/parts/rows_marks';
import { residualSpecs } from '@/plot/residual_specs';

export function ResidualsTab({ model }: { model: Model }) {
  const [file, setFile] = useState<{ name: string; bytes: Uint8Array }>();
  const output = useOutput(model);
  const fromFile = model.lineage?.runIds.length === 0;
  const key = fromFile && !file ? undefined : `residuals ${model.id} ${file?.name ?? ''} ${file?.bytes.length ?? ''}`;
  const asked = useAsked(key, (signal) => modelApi().listResiduals({ modelId: model.id, csv: file?.bytes ?? new Uint8Array() }, { signal }));
  return (
    <Panel title={`Residuals of ${outputSymbol(output)}: measured − model`} actions={<OutputChoice model={model} />}>
      {fromFile && (
        <FileInput label="The model was fitted to a file, whose rows the daemon did not keep: hand it in" accept=".csv,text/csv" chosen={file?.name} onFile={setFile} mostBytes={32 << 20} />
      )}
      {asked.failure && <Failed asked="Work out the residuals" failure={asked.failure} again={asked.again} />}
      {asked.value ? <RowsMarks runIds={model.lineage?.runIds ?? []}><Pictures answer={asked.value} model={model} output={output} /></RowsMarks> : !asked.failure && key && <Awaiting what="the residuals" />}
    </Panel>
  );
}

function Pictures({ answer, model, output }: { answer: ListResidualsResponse; model: Model; output: ModelOutput }) {
  const symbol = outputSymbol(output);
  const sets = answer.outputs.find((one) => one.output === symbol)?.namedSets ?? [];
  const specs = useMemo(() => residualSpecs(answer, symbol, summaryUnit(output), output.accuracy?.a90Calibration, `model-${model.id}`), [answer, symbol]);
  return (
    <>
      <p class="note muted">
        {countRows(answer.rowCount)}{answer.rowStep > 1n && `, every ${answer.rowStep}th drawn`}; ● calibration, ◇ validation; band: A90 of calibration, ±
        {significant(output.accuracy?.a90Calibration, 2)} {summaryUnit(output)}; one scale for all
      </p>
      {sets.length > 0 && (
        <p class="note">
          A90 by validation set: {sets.map((set) => `${set.name} ${significant(set.figures?.a90, 3)} ${summaryUnit(output)} (${countRows(set.figures?.rowCount)}, mean ${significant(set.figures?.mean, 2)})`).join('; ')}
        </p>
      )}
      {answer.runsWithoutZero.length > 0 && <Warned>The zero of {answer.runsWithoutZero.map((run) => `run ${run}`).join(', ')} is not known: the mean of its errors is taken out.</Warned>}
      {!answer.sameRows && <Warned>These are not the very rows the model was fitted from: rows were excluded or put back since, or it is another file.</Warned>}
      <div class="models-residuals">{specs.map((spec) => <Plot key={spec.title} spec={spec} height={200} />)}</div>
    </>
  );
}
