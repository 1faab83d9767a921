// Which output a picture speaks of; it stands in the address (?out=q2).
import type { Model, ModelOutput } from '@/api/gen/driftwise/v1/model_service_pb';
import { query } from '@/app/router';
import { SymbolChoice } from '@/ui/choice';
import { outputSymbol } from './figures';

export const useOutput = (model: Model): ModelOutput =>
  model.outputs.find((output) => outputSymbol(output) === query('out')) ?? model.outputs[0];

export function OutputChoice({ model }: { model: Model }) {
  return <SymbolChoice symbols={model.outputs.map(outputSymbol)} />;
}
