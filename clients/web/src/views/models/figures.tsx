// Figures of accuracy as they stand in tables and on tiles.
import type { Accuracy, Model, ModelOutput } from '@/api/gen/driftwise/v1/model_service_pb';
import { significant } from '@/format/numbers';
import { splitChannel, unitSign } from '@/format/units';

export const outputSymbol = (output: ModelOutput): string => splitChannel(output.channel).symbol;
export const summaryUnit = (output: ModelOutput): string => unitSign(output.summaryUnit);

// The figure that was held out, the best there is: on validation rows, else on blocks of time.
export function heldOut(accuracy: Accuracy | undefined): { value: number; from: string } | undefined {
  if (accuracy?.u90Validation !== undefined) return { value: accuracy.u90Validation, from: 'validation' };
  if (accuracy?.u90Blocks !== undefined) return { value: accuracy.u90Blocks, from: 'held-out blocks' };
  return undefined;
}

export function accuracyText(model: Model): string {
  return model.outputs
    .map((output) => `${outputSymbol(output)} ${significant(heldOut(output.accuracy)?.value ?? output.accuracy?.u90Calibration, 2)}`)
    .join(', ');
}

export const sourceText = (model: Model): string => {
  const runs = model.lineage?.runIds ?? [];
  if (runs.length > 0) return `${runs.length === 1 ? 'run' : 'runs'} ${runs.join(', ')}`;
  return model.lineage?.source || 'a file';
};
