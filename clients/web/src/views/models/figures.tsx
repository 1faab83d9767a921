// Figures of accuracy as they stand in tables and on tiles.
import type { Accuracy, Model, ModelOutput } from '@/api/gen/driftwise/v1/model_service_pb';
import { splitChannel, unitSign } from '@/format/units';
import { accuracyText } from '@/ui/accuracy';

export const outputSymbol = (output: ModelOutput): string => splitChannel(output.channel).symbol;
export const summaryUnit = (output: ModelOutput): string => unitSign(output.summaryUnit);

// The figure that was held out, the worse of validation rows and blocks of time.
export function heldOut(accuracy: Accuracy | undefined): { value: number; mean: number | undefined; from: string } | undefined {
  const validation = accuracy?.a90Validation === undefined ? undefined : { value: accuracy.a90Validation, mean: accuracy.meanValidation, from: 'validation rows' };
  const blocks = accuracy?.a90Blocks === undefined ? undefined : { value: accuracy.a90Blocks, mean: accuracy.meanBlocks, from: 'held-out blocks' };
  if (validation && blocks) return blocks.value > validation.value ? blocks : validation;
  return validation ?? blocks;
}

export const headingText = (model: Model): string => model.accuracy.map(accuracyText).join('; ');

export const sourceText = (model: Model): string => {
  const runs = model.lineage?.runIds ?? [];
  if (runs.length > 0) return `${runs.length === 1 ? 'run' : 'runs'} ${runs.join(', ')}`;
  return model.lineage?.source || 'a file';
};
